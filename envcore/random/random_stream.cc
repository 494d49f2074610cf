#include "envcore/random/random_stream.h"

#include <algorithm>
#include <limits>
#include <sstream>
#include <string>

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

void RandomStream::VisitState(StateArchive& archive) {
  uint64_t seed = seed_;
  uint64_t draws = draws_;
  archive.Bits("seed", seed, std::numeric_limits<uint32_t>::max());
  archive.Bits("draws", draws);
  if (archive.ok() && archive.restores()) {
    Seed(static_cast<int64_t>(seed));
    draws_ = draws;
    if (draws_ <= kRepeatedDrawsMax) {
      generator_.discard(draws_);
    }
  }
  if (draws_ > kRepeatedDrawsMax) {
    VisitGenerator(archive);
  }
}

// A generator as text, by the standard: its words and, in libstdc++, the number of words used.
// Restores only values that a generator can have.
void RandomStream::VisitGenerator(StateArchive& archive) {
  constexpr size_t kWordCount = Generator::state_size;
  std::vector<int32_t> words;
  if (!archive.restores()) {
    std::stringstream text;
    text << generator_;
    for (uint32_t word = 0; text >> word;) {
      words.push_back(static_cast<int32_t>(word));
    }
  }
  archive.Ints("generator", words, kWordCount + 1, std::numeric_limits<int32_t>::min(),
               std::numeric_limits<int32_t>::max());
  const bool is_whole = words.size() == kWordCount + 1 && words.back() >= 0 &&
                        words.back() <= static_cast<int32_t>(kWordCount);
  archive.Check(is_whole, "has a generator that is not 624 words and the number of those used");
  if (!archive.ok() || !archive.restores()) {
    return;
  }
  std::stringstream text;
  for (const int32_t word : words) {
    text << static_cast<uint32_t>(word) << ' ';
  }
  text >> generator_;
}

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
