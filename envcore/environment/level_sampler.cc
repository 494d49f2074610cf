#include "envcore/environment/level_sampler.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

constexpr double kOutputs = 4294967296;  // number of different outputs of a stream

// Mixes bits so that neighboring inputs give unrelated outputs: the finalizer of SplitMix64.
uint64_t Mixed(uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111eb;
  return bits ^ (bits >> 31);
}

Status CheckWeights(const std::vector<float>& weights, size_t seed_count) {
  if (weights.size() != seed_count) {
    return InvalidArgumentError(absl::StrCat("weights has ", weights.size(), " entries, must have ",
                                             seed_count, ", as level_seeds, or none"));
  }
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (!std::isfinite(weights[i]) || weights[i] < 0) {
      return InvalidArgumentError(
          absl::StrCat("weights[", i, "] is ", weights[i], ", must be finite and at least 0"));
    }
    sum += static_cast<double>(weights[i]);
  }
  if (sum == 0) {
    return InvalidArgumentError("weights are all 0, must have a positive sum");
  }
  return OkStatus();
}

}  // namespace

StatusOr<std::shared_ptr<const LevelSampler>> LevelSampler::Create(
    std::vector<int32_t> level_seeds, const std::vector<float>& weights, int64_t rand_seed) {
  if (level_seeds.empty() || level_seeds.size() > static_cast<size_t>(kLevelSeedsMax)) {
    return InvalidArgumentError(absl::StrCat("level_seeds has ", level_seeds.size(),
                                             " entries, must have 1 to ", kLevelSeedsMax));
  }
  std::vector<double> weight_sums;
  if (!weights.empty()) {
    if (Status status = CheckWeights(weights, level_seeds.size()); !status.ok()) {
      return status;
    }
    double sum = 0;
    for (const float weight : weights) {
      weight_sums.push_back(sum += static_cast<double>(weight));
    }
  }
  return std::shared_ptr<const LevelSampler>(new LevelSampler(
      std::move(level_seeds), weights, std::move(weight_sums), static_cast<uint32_t>(rand_seed)));
}

uint32_t LevelSampler::StreamSeedOf(int32_t environment) const {
  const uint64_t both = uint64_t{rand_seed_} << 32 | static_cast<uint32_t>(environment);
  return static_cast<uint32_t>(Mixed(both + 0x9e3779b97f4a7c15) >> 32);
}

int32_t LevelSampler::Draw(RandomStream& stream) const {
  if (weight_sums_.empty()) {
    return stream.OneOf(level_seeds_);
  }
  // The first seed with a cumulative weight above `place`. A seed of weight 0 is never chosen,
  // because its sum equals the one before it.
  const double place = stream.Raw() / kOutputs * weight_sums_.back();
  const auto found = std::upper_bound(weight_sums_.begin(), weight_sums_.end(), place);
  return level_seeds_[static_cast<size_t>(found - weight_sums_.begin())];
}

}  // namespace procgen
