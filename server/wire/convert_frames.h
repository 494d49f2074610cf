#ifndef SERVER_WIRE_CONVERT_FRAMES_H_
#define SERVER_WIRE_CONVERT_FRAMES_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/run.pb.h"
#include "server/pool/pool_session.h"
#include "server/pool/quota/limits.h"
#include "server/pool/watch/frame_subscriber.h"

namespace procgen {

// View and size of frames to render.
struct RenderSpec {
  View view = View::kHuman;
  int32_t size_px = 0;
};
RenderSpec RenderSpecOf(const v1::Render& request);

// Checks a render request. Errors: INVALID_ARGUMENT an environment, size or format is out of range;
// RESOURCE_EXHAUSTED the frames do not fit in a response.
absl::Status CheckRender(const v1::Render& request, const PoolSession& pool, const Limits& limits);

// Checks and converts a watch request. Errors: as CheckRender; INVALID_ARGUMENT the frame rate is
// out of range.
absl::StatusOr<WatchSpec> WatchSpecOf(const v1::WatchPoolRequest& request, const PoolSession& pool,
                                      const Limits& limits);

// Converts the images of `frames`, which are uint8 [size_px, size_px, 3], to `format` in place.
void WriteFrames(v1::FrameFormat format, google::protobuf::RepeatedPtrField<v1::Frame>* frames);

// Encodes a frame set and serialises it as a WatchPoolResponse.
absl::Cord EncodeWatched(v1::FrameFormat format, FrameSet frame_set);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_FRAMES_H_
