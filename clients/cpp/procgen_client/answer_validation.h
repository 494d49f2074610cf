#ifndef PROCGEN_CLIENT_ANSWER_VALIDATION_H_
#define PROCGEN_CLIENT_ANSWER_VALIDATION_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "google/protobuf/repeated_field.h"
#include "procgen/v1/pools.pb.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/states.pb.h"

namespace procgen_client {

// Validation of what a server answers beside the stream (ResponseValidator has the stream's),
// before it is used. Errors of all: INTERNAL (the message says what was given and what was
// expected).

// A pool of this name, whose counts and sizes are within the contract's bounds.
absl::Status ValidatePool(const procgen::v1::Pool& pool, const std::string& name);
// The pool that was asked for.
absl::Status ValidateCreatedPool(const procgen::v1::Pool& pool,
                                 const procgen::v1::CreatePoolRequest& request);
// Frames of these environments in this order, of `size_px` (0: any size) and `format`.
absl::Status ValidateFrames(const google::protobuf::RepeatedPtrField<procgen::v1::Frame>& frames,
                            absl::Span<const int32_t> environments, int32_t size_px,
                            procgen::v1::FrameFormat format);
// A page of snapshots, after those of `before` environments: of `environments` in this order, or of
// all if none is named.
absl::Status ValidateStates(const procgen::v1::SaveStatesResponse& page,
                            absl::Span<const int32_t> environments, size_t before);
// An episode of this environment, whose parts fit together.
absl::Status ValidateEpisode(const procgen::v1::Episode& episode, int32_t environment);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_ANSWER_VALIDATION_H_
