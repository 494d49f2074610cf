#ifndef SERVER_WEB_SESSION_FRAME_ENCODER_H_
#define SERVER_WEB_SESSION_FRAME_ENCODER_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "procgen/v1/render.pb.h"
#include "server/encoding/deflater.h"
#include "server/web/json/message.h"

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
  // `watch`: its number.
  FrameEncoder(int64_t watch, FrameEncoding encoding);

  // Returns the event `frames`. REQUIRES: frames of the watch, PNG files for kPng, else pixels.
  WireMessage Encode(procgen::v1::WatchPoolResponse response);

 private:
  // Returns the difference of a frame to the previous one of its environment.
  std::string Deflate(int32_t environment, std::string pixels);

  const int64_t watch_;
  const FrameEncoding encoding_;
  std::optional<Deflater> deflater_;
  std::map<int32_t, std::string> sent_;  // environment -> pixels of its last frame
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_FRAME_ENCODER_H_
