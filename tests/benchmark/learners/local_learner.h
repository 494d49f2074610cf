#ifndef TESTS_BENCHMARK_LEARNERS_LOCAL_LEARNER_H_
#define TESTS_BENCHMARK_LEARNERS_LOCAL_LEARNER_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "envcore/pool/shared_art.h"
#include "tests/benchmark/measuring/action_script.h"

namespace procgen {

// Options of a LocalLearner.
struct LocalCase {
  std::string game;
  DistributionMode mode = DistributionMode::kEasy;
  int worker_count = 1;  // the calling thread is one of them
  bool drawn = true;
  std::shared_ptr<const SharedArt> art = nullptr;  // null: the built-in art
};

// A pool in this process with random actions and memory for its batches.
// Threads: compatible (one thread at a time).
class LocalLearner {
 public:
  static constexpr int32_t kEnvCount = 64;

  // Creates the pool and steps it until the environments are in a typical mixture of states.
  static absl::StatusOr<LocalLearner> Start(const LocalCase& local_case,
                                            int32_t env_count = kEnvCount);

  // Steps all environments once.
  absl::Status Step();

 private:
  LocalLearner(std::unique_ptr<Pool> pool, const LocalCase& local_case);

  std::unique_ptr<Pool> pool_;
  ActionScript actions_;
  std::vector<uint8_t> observations_;  // [env_count, 64, 64, 3]; empty: not drawn
  BatchNumbers numbers_;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_LEARNERS_LOCAL_LEARNER_H_
