#ifndef SERVER_WIRE_CONVERT_FRAMES_H_
#define SERVER_WIRE_CONVERT_FRAMES_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "procgen/v1/render.pb.h"
#include "server/session/pool/pool_session.h"
#include "server/session/quota/limits.h"
#include "server/session/watch/frame_subscriber.h"

namespace procgen {

// How environments are to be drawn.
struct RenderSpec {
  View view = View::kHuman;
  int32_t size_px = 0;
};
RenderSpec RenderSpecOf(const v1::RenderEnvironmentsRequest& request);

// Checks what is to be drawn of a pool. Errors: INVALID_ARGUMENT an environment, size or format out
// of range; RESOURCE_EXHAUSTED the frames do not fit.
absl::Status CheckRender(const v1::RenderEnvironmentsRequest& request, const PoolSession& pool,
                         const Limits& limits);

// What is to be watched of a pool. Errors: as CheckRender, and INVALID_ARGUMENT for a rate.
absl::StatusOr<WatchSpec> WatchSpecOf(const v1::WatchPoolRequest& request, const PoolSession& pool,
                                      const Limits& limits);

// Puts the pixels that are in the frames, uint8 [side, side, 3], into the format.
void WriteFrames(v1::FrameFormat format, google::protobuf::RepeatedPtrField<v1::Frame>* frames);

// A frame set as a WatchPoolResponse, serialised.
absl::Cord EncodeWatched(v1::FrameFormat format, FrameSet frame_set);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_FRAMES_H_
