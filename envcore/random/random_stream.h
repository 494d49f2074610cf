#ifndef ENVCORE_RANDOM_RANDOM_STREAM_H_
#define ENVCORE_RANDOM_RANDOM_STREAM_H_

#include <cstdint>
#include <random>
#include <vector>

#include "absl/types/span.h"
#include "envcore/state/state_archive.h"

namespace procgen {

// A stream of random numbers: mt19937 and the draws that the rules of the games use. Equal seeds
// and equal draws give equal values on every machine. Every draw takes exactly one 32-bit output
// unless its comment says otherwise. Threads: compatible (one thread at a time).
class RandomStream {
 public:
  // A stream seeded with 0.
  RandomStream() : RandomStream(0) {}
  // `seed` is used modulo 2^32: -5 becomes 0xfffffffb.
  explicit RandomStream(int64_t seed) { Seed(seed); }

  // Restarts the stream from `seed` and sets the number of draws to 0.
  void Seed(int64_t seed);
  // Number of outputs taken since the stream was seeded.
  uint64_t draws() const { return draws_; }
  // The last seed, modulo 2^32.
  uint32_t seed() const { return seed_; }

  // Returns the next output.
  uint32_t Raw() {
    ++draws_;
    return generator_();
  }
  // An integer in [0, n). REQUIRES: n > 0.
  int32_t Int(int32_t n);
  // An integer in [low, high). Difference and sum wrap in 32 bits. REQUIRES: low != high.
  int32_t Int(int32_t low, int32_t high);
  // A float in [0, 1]: output / 2^32 rounded to f32, so 1.0 has probability 2^-25.
  float Unit();
  // Unit() * (high - low) + low, in f32.
  float Range(float low, float high);
  // Unit() > 0.5.
  bool Coin();

  // The element at index Int(size). REQUIRES: `list` is not empty.
  template <typename T>
  const T& OneOf(const std::vector<T>& list) {
    return list[static_cast<size_t>(Int(static_cast<int32_t>(list.size())))];
  }
  // `n` different elements of `list`, in drawing order; takes n draws. If n > size: the whole list
  // in its own order, without a draw.
  template <typename T>
  std::vector<T> NOf(std::vector<T> list, int32_t n) {
    if (n > static_cast<int32_t>(list.size())) {
      return list;
    }
    std::vector<T> chosen;
    chosen.reserve(static_cast<size_t>(n));
    for (int32_t i = 0; i < n; ++i) {
      const int32_t index = Int(static_cast<int32_t>(list.size()));
      chosen.push_back(list[static_cast<size_t>(index)]);
      list.erase(list.begin() + index);
    }
    return chosen;
  }
  // `k` different integers in [0, n), in drawing order. Draws again when a value repeats. REQUIRES:
  // k <= n.
  std::vector<int32_t> Distinct(int32_t n, int32_t k);
  // Distributes `x` units over `n` bins and returns the count of each bin. Takes x draws (none if x
  // <= 0).
  std::vector<int32_t> Split(int32_t x, int32_t n);

  // Saves or restores the stream as its seed and number of draws; restoring repeats the draws.
  // After more than kRepeatedDrawsMax draws it also saves the generator's state.
  void VisitState(StateArchive& archive);

 private:
  static constexpr uint64_t kRepeatedDrawsMax = uint64_t{1} << 20;

  void VisitGenerator(StateArchive& archive);

  // std::mt19937 with 32-bit words instead of the 64-bit words of libstdc++: equal numbers in half
  // the memory.
  using Generator =
      std::mersenne_twister_engine<uint32_t, 32, 624, 397, 31, 0x9908b0df, 11, 0xffffffff, 7,
                                   0x9d2c5680, 15, 0xefc60000, 18, 1812433253>;
  Generator generator_;
  uint32_t seed_ = 0;
  uint64_t draws_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RANDOM_RANDOM_STREAM_H_
