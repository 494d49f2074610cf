#ifndef ENVCORE_ENVIRONMENT_LEVEL_SAMPLER_H_
#define ENVCORE_ENVIRONMENT_LEVEL_SAMPLER_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "envcore/random/random_stream.h"
#include "envcore/status/status.h"

namespace procgen {

// Draws levels from a weighted list of seeds, for curricula. Equal lists, weights and seeds give
// equal choices on every machine. Immutable, so that the environments of a pool share one.
// Threads: thread-safe.
class LevelSampler {
 public:
  // Largest number of level seeds.
  static constexpr int64_t kLevelSeedsMax = 1'000'000;

  // `level_seeds`: 1 to kLevelSeedsMax entries; any values, duplicates allowed. `weights`: one per
  // seed, relative, finite, at least 0, with a positive sum; empty: uniform. `rand_seed`: used
  // modulo 2^32. Errors: INVALID_ARGUMENT (the message gives the value and what is allowed).
  static StatusOr<std::shared_ptr<const LevelSampler>> Create(std::vector<int32_t> level_seeds,
                                                              const std::vector<float>& weights,
                                                              int64_t rand_seed);

  // The arguments of Create; `rand_seed` modulo 2^32.
  const std::vector<int32_t>& level_seeds() const { return level_seeds_; }
  const std::vector<float>& weights() const { return weights_; }
  uint32_t rand_seed() const { return rand_seed_; }

  // The seed of the level-seed stream of an environment. `environment`: index in the whole pool, so
  // that a shard makes the same choices as the whole.
  uint32_t StreamSeedOf(int32_t environment) const;
  // Returns the next level seed. Takes one draw from `stream`.
  int32_t Draw(RandomStream& stream) const;

 private:
  LevelSampler(std::vector<int32_t> level_seeds, std::vector<float> weights,
               std::vector<double> weight_sums, uint32_t rand_seed)
      : level_seeds_(std::move(level_seeds)),
        weights_(std::move(weights)),
        weight_sums_(std::move(weight_sums)),
        rand_seed_(rand_seed) {}

  const std::vector<int32_t> level_seeds_;
  const std::vector<float> weights_;  // one per seed; empty: uniform
  // Cumulative weights, one per seed; empty: uniform.
  const std::vector<double> weight_sums_;
  const uint32_t rand_seed_;
};

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_LEVEL_SAMPLER_H_
