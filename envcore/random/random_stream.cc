#include "envcore/random/random_stream.h"

#include <algorithm>

namespace procgen {

void RandomStream::Seed(int64_t seed) {
  seed_ = static_cast<uint32_t>(seed);
  draws_ = 0;
  generator_.seed(seed_);
}

int32_t RandomStream::Int(int32_t n) {
  return static_cast<int32_t>(Raw() % static_cast<uint32_t>(n));
}

int32_t RandomStream::Int(int32_t low, int32_t high) {
  const uint32_t range = static_cast<uint32_t>(high) - static_cast<uint32_t>(low);
  return static_cast<int32_t>(static_cast<uint32_t>(low) + Raw() % range);
}

float RandomStream::Unit() { return static_cast<float>(Raw() / 4294967296.0); }

float RandomStream::Range(float low, float high) { return Unit() * (high - low) + low; }

bool RandomStream::Coin() { return Unit() > 0.5F; }

std::vector<int32_t> RandomStream::Distinct(int32_t n, int32_t k) {
  std::vector<bool> had(static_cast<size_t>(n), false);
  std::vector<int32_t> values;
  values.reserve(static_cast<size_t>(k));
  while (static_cast<int32_t>(values.size()) < k) {
    const int32_t value = Int(n);
    if (!had[static_cast<size_t>(value)]) {
      had[static_cast<size_t>(value)] = true;
      values.push_back(value);
    }
  }
  return values;
}

std::vector<int32_t> RandomStream::Split(int32_t x, int32_t n) {
  std::vector<int32_t> bins(static_cast<size_t>(n), 0);
  for (int32_t i = 0; i < x; ++i) {
    ++bins[static_cast<size_t>(Int(n))];
  }
  return bins;
}

}  // namespace procgen
