#ifndef TESTS_BENCHMARK_YARDSTICK_H_
#define TESTS_BENCHMARK_YARDSTICK_H_

#include <cstdint>
#include <random>
#include <vector>

#include "absl/time/time.h"

namespace procgen {

// A fixed piece of single-thread work that the cost of a step is divided by, so that figures can be
// compared between machines, and on one machine whose speed drifts.
//
// One unit: 624 outputs of mt19937 (one turn of its state), then one picture of 64 x 64 pixels RGB,
// sampled nearest-neighbour at three source pixels a pixel from an image of 256 x 256 with cut-out
// alpha. That is the kind of work a step is made of. Procgen 0.10.7 was measured in the same
// unit (upstream_costs.h), so the work must never change.
// Threads: compatible (one thread at a time).
class Yardstick {
 public:
  Yardstick();

  // The time of one unit now: the best of several rounds, about 30 ms in all.
  absl::Duration MeasureUnit();

 private:
  void DoUnit();
  // Draws the image into frame_, beginning in source row `first_row` with `step` per pixel, both in
  // 1/65536 of a source pixel.
  void Sample(uint32_t first_row, uint32_t step);

  std::mt19937 random_;
  std::vector<uint32_t> image_;  // 0xAARRGGBB            uint32  [256, 256]
  std::vector<uint8_t> frame_;   // red, green, blue      uint8   [64, 64, 3]
  uint32_t sum_ = 0;             // what all work flows into, so that none can be left out
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_YARDSTICK_H_
