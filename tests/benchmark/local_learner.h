#ifndef TESTS_BENCHMARK_LOCAL_LEARNER_H_
#define TESTS_BENCHMARK_LOCAL_LEARNER_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "envcore/pool/shared_art.h"
#include "tests/benchmark/action_tape.h"

namespace procgen {

// What is measured of the engine.
struct Course {
  std::string game;
  DistributionMode mode = DistributionMode::kEasy;
  int worker_count = 1;  // the calling thread is one of them
  bool drawn = true;
  std::shared_ptr<const SharedArt> art = nullptr;  // null: the built-in art
};

// A pool in this process, the random actions that it is given, and memory for what it answers.
// Threads: compatible (one thread at a time).
class LocalLearner {
 public:
  static constexpr int32_t kEnvCount = 64;

  // The environments have gone from their common start to a typical mixture of states.
  static absl::StatusOr<LocalLearner> Start(const Course& course, int32_t env_count = kEnvCount);

  // Steps all environments once.
  absl::Status Step();
  // What the environments show: [kEnvCount, 64, 64, 3], or empty where nothing is drawn.
  absl::Span<const uint8_t> observations() const { return observations_; }

 private:
  LocalLearner(std::unique_ptr<Pool> pool, bool drawn);

  std::unique_ptr<Pool> pool_;
  ActionTape actions_;
  std::vector<uint8_t> observations_;  // empty: not drawn
  std::vector<float> rewards_;
  std::vector<uint8_t> first_;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_LOCAL_LEARNER_H_
