#include "tests/benchmark/measuring/yardstick.h"

#include <algorithm>
#include <cstddef>
#include <functional>

#include "tests/benchmark/measuring/time_now.h"

namespace procgen {
namespace {

constexpr int kImageSide = 256;
constexpr int kFrameSide = 64;
constexpr int kDrawsPerUnit = 624;
constexpr int kUnitsPerRound = 500;
constexpr int kRounds = 10;
constexpr uint32_t kThreePixels = 3U << 16;
constexpr uint32_t kHalfPixel = 1U << 15;
constexpr uint32_t kOpaque = 1U << 31;

}  // namespace

Yardstick::Yardstick()
    : random_(1),
      image_(static_cast<size_t>(kImageSide) * kImageSide),
      frame_(static_cast<size_t>(kFrameSide) * kFrameSide * 3) {
  std::generate(image_.begin(), image_.end(), std::ref(random_));
}

absl::Duration Yardstick::MeasureUnit() {
  absl::Duration best = absl::InfiniteDuration();
  for (int round = 0; round < kRounds; ++round) {
    const absl::Duration start = TimeNow(TimeKind::kThread);
    for (int unit = 0; unit < kUnitsPerRound; ++unit) {
      DoUnit();
    }
    best = std::min(best, (TimeNow(TimeKind::kThread) - start) / kUnitsPerRound);
  }
  return best;
}

void Yardstick::DoUnit() {
  uint32_t sum = sum_;
  for (int draw = 0; draw < kDrawsPerUnit; ++draw) {
    sum += static_cast<uint32_t>(random_());
  }
  Sample(sum & 0xffff, kThreePixels + (sum & 0xff));
  sum_ = sum + frame_[sum % frame_.size()];
}

void Yardstick::Sample(uint32_t first_row, uint32_t step) {
  uint8_t* out = frame_.data();
  uint32_t source_y = first_row;
  for (int y = 0; y < kFrameSide; ++y) {
    const uint32_t* row = &image_[static_cast<size_t>((source_y >> 16) % kImageSide) * kImageSide];
    uint32_t source_x = kHalfPixel;
    for (int x = 0; x < kFrameSide; ++x) {
      const uint32_t pixel = row[(source_x >> 16) % kImageSide];
      if ((pixel & kOpaque) != 0) {
        out[0] = static_cast<uint8_t>(pixel >> 16);
        out[1] = static_cast<uint8_t>(pixel >> 8);
        out[2] = static_cast<uint8_t>(pixel);
      }
      source_x += step;
      out += 3;
    }
    source_y += step;
  }
}

}  // namespace procgen
