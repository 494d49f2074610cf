#ifndef PROCGEN_CLIENT_INTERNAL_ANSWER_VALIDATION_H_
#define PROCGEN_CLIENT_INTERNAL_ANSWER_VALIDATION_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "google/protobuf/repeated_field.h"
#include "procgen/v1/pools.pb.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/states.pb.h"

namespace procgen_client {

// Validation of unary responses before they are used. ResponseValidator validates those of a
// stream. Errors of all functions: INTERNAL; the message contains the value given and the value
// expected.

// A pool of this name, with counts and sizes in the ranges of the API.
absl::Status ValidatePool(const procgen::v1::Pool& pool, const std::string& name);
// A pool that `request` creates.
absl::Status ValidateCreatedPool(const procgen::v1::Pool& pool,
                                 const procgen::v1::CreatePoolRequest& request);
// Frames of `environments` in this order, of `size_px` pixels a side (0: any size) in `format`.
absl::Status ValidateFrames(const google::protobuf::RepeatedPtrField<procgen::v1::Frame>& frames,
                            absl::Span<const int32_t> environments, int32_t size_px,
                            procgen::v1::FrameFormat format);
// A page of snapshots of `environments` in this order (empty: all), after `before` snapshots on
// earlier pages.
absl::Status ValidateStates(const procgen::v1::SaveStatesResponse& page,
                            absl::Span<const int32_t> environments, size_t before);
// A consistent episode of `environment`.
absl::Status ValidateEpisode(const procgen::v1::Episode& episode, int32_t environment);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_ANSWER_VALIDATION_H_
