#ifndef TESTS_BENCHMARK_LOCAL_LEARNER_H_
#define TESTS_BENCHMARK_LOCAL_LEARNER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "envcore/pool/shared_art.h"
#include "tests/benchmark/action_script.h"

namespace procgen {

// What is measured of the engine.
struct LocalCase {
  std::string game;
  DistributionMode mode = DistributionMode::kEasy;
  int worker_count = 1;  // the calling thread is one of them
  bool drawn = true;
  std::shared_ptr<const SharedArt> art = nullptr;  // null: the built-in art
  // Batches that are written in turn, so that one can be read while the next is written. 1: each
  // step writes over what the one before has answered.
  int batch_count = 1;
  bool answers_all = false;  // all that a stream answers, otherwise observations, rewards and first
};

// A pool in this process, the random actions that it is given, and memory for what it answers.
// Threads: compatible (one thread at a time).
class LocalLearner {
 public:
  static constexpr int32_t kEnvCount = 64;

  // The environments have gone from their common start to a typical mixture of states.
  static absl::StatusOr<LocalLearner> Start(const LocalCase& local_case,
                                            int32_t env_count = kEnvCount);

  // Steps all environments once.
  absl::Status Step();
  // What the environments show: [kEnvCount, 64, 64, 3], or empty where nothing is drawn.
  absl::Span<const uint8_t> observations() const {
    return answers_[step_ % answers_.size()].observations;
  }

 private:
  // Memory of a batch.
  struct Answer {
    std::vector<uint8_t> observations;  // empty: not drawn
    BatchNumbers numbers;
  };

  // Where the next step writes it.
  Batch BatchIn(Answer* answer) const;

  LocalLearner(std::unique_ptr<Pool> pool, const LocalCase& local_case);

  std::unique_ptr<Pool> pool_;
  ActionScript actions_;
  std::vector<Answer> answers_;
  bool answers_all_;
  size_t step_ = 0;  // its answer is answers_[step_ % answers_.size()]
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_LOCAL_LEARNER_H_
