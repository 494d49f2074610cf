#ifndef ENVCORE_ENVIRONMENT_LEVEL_SAMPLER_H_
#define ENVCORE_ENVIRONMENT_LEVEL_SAMPLER_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "envcore/random/random_stream.h"

namespace procgen {

// Chooses levels from a list, each with a weight: what a curriculum replaces as the learner learns.
// Equal lists, weights and seeds give equal choices on every machine. Immutable, so that all
// environments of a pool share one. Threads: any method from any thread.
class LevelSampler {
 public:
  // The most level seeds that a list can have.
  static constexpr int64_t kLevelSeedsMax = 1'000'000;

  // `level_seeds`: [1 ... kLevelSeedsMax], any values, also the same twice. `weights`: of each
  // seed, relative, finite, at least 0, their sum above 0; or empty: all are equal. `rand_seed`
  // counts modulo 2^32. Errors: INVALID_ARGUMENT (the message names what was given and what is
  // allowed).
  static absl::StatusOr<std::shared_ptr<const LevelSampler>> Create(
      std::vector<int32_t> level_seeds, const std::vector<float>& weights, int64_t rand_seed);

  // What it was made with; `rand_seed` modulo 2^32.
  const std::vector<int32_t>& level_seeds() const { return level_seeds_; }
  const std::vector<float>& weights() const { return weights_; }
  uint32_t rand_seed() const { return rand_seed_; }

  // What an environment's choice of levels is seeded with. `environment`: its index in the whole,
  // so that a shard chooses as the whole does.
  uint32_t StreamSeedOf(int32_t environment) const;
  // The next level seed; takes one draw.
  int32_t Draw(RandomStream& stream) const;

 private:
  LevelSampler(std::vector<int32_t> level_seeds, std::vector<float> weights,
               std::vector<double> weight_sums, uint32_t rand_seed)
      : level_seeds_(std::move(level_seeds)),
        weights_(std::move(weights)),
        weight_sums_(std::move(weight_sums)),
        rand_seed_(rand_seed) {}

  const std::vector<int32_t> level_seeds_;
  const std::vector<float> weights_;  // of each seed; empty: all are equal
  // Of each seed its own weight and those before it; empty: all weights are equal.
  const std::vector<double> weight_sums_;
  const uint32_t rand_seed_;
};

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_LEVEL_SAMPLER_H_
