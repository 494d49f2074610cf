#ifndef TESTS_BENCHMARK_LEARNERS_LOCAL_LEARNER_H_
#define TESTS_BENCHMARK_LEARNERS_LOCAL_LEARNER_H_

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
#include "tests/benchmark/measuring/action_script.h"

namespace procgen {

// Options of a LocalLearner.
struct LocalCase {
  std::string game;
  DistributionMode mode = DistributionMode::kEasy;
  int worker_count = 1;  // the calling thread is one of them
  bool drawn = true;
  std::shared_ptr<const SharedArt> art = nullptr;  // null: the built-in art
  // Number of batches that steps write in turn. With 1, each step overwrites the previous batch.
  int batch_count = 1;
  bool answers_all = false;  // all arrays of a stream's batch, else observations, rewards and first
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
  // Observations of the last step: [kEnvCount, 64, 64, 3], or empty if nothing is drawn.
  absl::Span<const uint8_t> observations() const {
    return answers_[step_ % answers_.size()].observations;
  }

 private:
  // Memory of one batch.
  struct Answer {
    std::vector<uint8_t> observations;  // empty: not drawn
    BatchNumbers numbers;
  };

  // Returns the spans of `answer` that the next step writes.
  Batch BatchIn(Answer* answer) const;

  LocalLearner(std::unique_ptr<Pool> pool, const LocalCase& local_case);

  std::unique_ptr<Pool> pool_;
  ActionScript actions_;
  std::vector<Answer> answers_;
  bool answers_all_;
  size_t step_ = 0;  // its batch is answers_[step_ % answers_.size()]
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_LEARNERS_LOCAL_LEARNER_H_
