#ifndef TESTS_BENCHMARK_MEASURING_ACTION_SCRIPT_H_
#define TESTS_BENCHMARK_MEASURING_ACTION_SCRIPT_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace procgen {

// A fixed sequence of random actions for env_count environments, drawn in advance so that drawing
// is not measured. Threads: compatible (one thread at a time).
class ActionScript {
 public:
  explicit ActionScript(int32_t env_count);

  // The actions of the next step: [env_count].
  absl::Span<const int32_t> Next();

 private:
  size_t env_count_;
  std::vector<int32_t> actions_;  // int32  [rows, env_count]
  size_t row_ = 0;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_MEASURING_ACTION_SCRIPT_H_
