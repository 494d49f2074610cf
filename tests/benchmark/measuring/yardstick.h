#ifndef TESTS_BENCHMARK_MEASURING_YARDSTICK_H_
#define TESTS_BENCHMARK_MEASURING_YARDSTICK_H_

#include <cstdint>
#include <random>
#include <vector>

#include "absl/time/time.h"

namespace procgen {

// A fixed single-thread workload, the unit in which costs are given. It makes results comparable
// between machines, and on one machine whose speed varies.
//
// One unit: 624 outputs of mt19937 (one refill of its state), then one RGB image of 64 x 64 pixels,
// sampled nearest-neighbour at three source pixels per pixel from an image of 256 x 256 with
// cut-out alpha. A step consists of similar work. Procgen 0.10.7 was measured in the same unit
// (upstream_costs.h), so the workload must never change.
// Threads: compatible (one thread at a time).
class Yardstick {
 public:
  Yardstick();

  // Measures the time of one unit: the best of several rounds. Takes about 30 ms.
  absl::Duration MeasureUnit();

 private:
  void DoUnit();
  // Samples the image into frame_, from source row `first_row` with `step` per pixel, both in
  // 1/65536 of a source pixel.
  void Sample(uint32_t first_row, uint32_t step);

  std::mt19937 random_;
  std::vector<uint32_t> image_;  // 0xAARRGGBB            uint32  [256, 256]
  std::vector<uint8_t> frame_;   // red, green, blue      uint8   [64, 64, 3]
  uint32_t sum_ = 0;             // depends on all work, so that the compiler keeps it
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_MEASURING_YARDSTICK_H_
