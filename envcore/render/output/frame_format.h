#ifndef ENVCORE_RENDER_OUTPUT_FRAME_FORMAT_H_
#define ENVCORE_RENDER_OUTPUT_FRAME_FORMAT_H_

#include <cstddef>
#include <cstdint>

namespace procgen {

enum class Color : int32_t {
  kRgb = 0,        // three channels: red, green, blue
  kGrayscale = 1,  // one: (77 red + 150 green + 29 blue + 128) / 256, rounded down (luma, BT.601)
};
inline constexpr Color kColorMax = Color::kGrayscale;

// The order of a frame's axes. With one channel both are the same bytes.
enum class Layout : int32_t {
  kHwc = 0,  // uint8 [side, side, channels]
  kChw = 1,  // uint8 [channels, side, side]
};

// In which bytes a frame is written: square, top row first.
struct FrameFormat {
  int32_t size_px = 64;
  Color color = Color::kRgb;
  Layout layout = Layout::kHwc;

  constexpr int32_t channels() const { return color == Color::kRgb ? 3 : 1; }
  // Bytes of one frame.
  constexpr size_t bytes() const {
    return static_cast<size_t>(size_px) * static_cast<size_t>(size_px) *
           static_cast<size_t>(channels());
  }
  bool operator==(const FrameFormat&) const = default;
};

// What Procgen 0.10.7 shows to an agent: 64 x 64, RGB, HWC.
inline constexpr FrameFormat kUpstreamFrameFormat;

}  // namespace procgen

#endif  // ENVCORE_RENDER_OUTPUT_FRAME_FORMAT_H_
