#ifndef SERVER_WEB_SESSION_FRAME_ENCODER_H_
#define SERVER_WEB_SESSION_FRAME_ENCODER_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "procgen/v1/render.pb.h"
#include "server/encoding/deflater.h"
#include "server/web/json/message.h"
#include "server/web/session/difference_cache.h"

namespace procgen::web {

// Formats of frames; README.md of server/web/json defines them.
enum class FrameEncoding { kRgb, kDeflate, kPng };
// "rgb", "deflate" or "png".
const char* NameOf(FrameEncoding encoding);

// Encodes the frames of a watch. For kDeflate they must all be sent, in order, since each is
// relative to the one before. Memory: for kDeflate, a frame of each environment and 256 KiB.
// Threads: compatible (one thread at a time).
class FrameEncoder {
 public:
  // `watch`: its number. `differences` must outlive this.
  FrameEncoder(int64_t watch, FrameEncoding encoding, DifferenceCache* differences);

  // Returns the event `frames`. REQUIRES: frames of the watch, PNG files for kPng, else pixels.
  WireMessage Encode(procgen::v1::WatchPoolResponse response);

 private:
  struct SentFrame {
    std::string pixels;
    size_t hash = 0;
  };

  // Returns the difference of a frame to the previous one of its environment.
  std::string Deflate(int32_t environment, std::string pixels);

  const int64_t watch_;
  const FrameEncoding encoding_;
  std::optional<Deflater> deflater_;
  DifferenceCache* const differences_;
  std::map<int32_t, SentFrame> sent_;  // environment -> its last frame
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_FRAME_ENCODER_H_
