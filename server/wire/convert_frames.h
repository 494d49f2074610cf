#ifndef SERVER_WIRE_CONVERT_FRAMES_H_
#define SERVER_WIRE_CONVERT_FRAMES_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/run.pb.h"
#include "server/encoding/observation_encoder.h"
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

// WatchSpec::format of a watch with ENCODING_DELTA_ZSTD; all others are a v1::FrameFormat.
inline constexpr int32_t kDeltaFormat = -1;

// Encodes a frame set and serialises it as a WatchPoolResponse. With kDeltaFormat it is one without
// images, followed by all images: what DeltaFrameEncoder encodes for each stream.
absl::Cord EncodeWatched(int32_t format, FrameSet frame_set);

// Encodes the frame sets of one stream with ENCODING_DELTA_ZSTD, each relative to the one before.
// Threads: compatible (one at a time).
class DeltaFrameEncoder {
 public:
  explicit DeltaFrameEncoder(const WatchSpec& spec);
  // Its memory while it encodes.
  static int64_t BytesOf(const WatchSpec& spec);

  // `frame_set`: of EncodeWatched. Returns a serialised WatchPoolResponse.
  std::string Encode(const absl::Cord& frame_set);

 private:
  const size_t image_bytes_;  // of a frame set
  ObservationEncoder encoder_;
};

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_FRAMES_H_
