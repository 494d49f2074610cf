#ifndef ENVCORE_ENVIRONMENT_FINGERPRINT_H_
#define ENVCORE_ENVIRONMENT_FINGERPRINT_H_

#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"
#include "envcore/environment/environment_options.h"

namespace procgen {

// A running hash of an episode: equal fingerprints mean, but for chance, the same game, options,
// levels, actions, rewards and end. It is the FNV-1a hash of 64 bits over these bytes (numbers are
// little-endian, 32 bits; bytes with one value are 0 or 1):
//
//   begin  the game's name, byte 0, distribution_mode, debug_mode (as numbers), and as a byte each
//          center_agent, use_backgrounds, use_generated_assets, use_monochrome_assets,
//          restrict_themes, paint_vel_info, use_sequential_levels
//   level  'L', level seed                                           at the beginning of each level
//   step   'S', action (-1 included), the bits of the reward (f32), ends
//          ends: 1 the level was completed + 2 terminated + 4 truncated             after each step
//
// FNV-1a: h = 14695981039346656037; for each byte b: h = (h xor b) * 1099511628211 modulo 2^64.
// A repeated action is so many steps. What follows an episode's end (AutoresetMode) has no part in
// it.
class Fingerprint {
 public:
  Fingerprint() = default;

  void Begin(absl::string_view game, const EnvironmentOptions& options);
  void AddLevel(int32_t level_seed);
  void AddStep(int32_t action, float reward, bool level_complete, bool terminated, bool truncated);

  uint64_t value() const { return value_; }
  // Goes on from a value that was had before.
  void Restore(uint64_t value) { value_ = value; }

 private:
  static constexpr uint64_t kOffsetBasis = 14695981039346656037U;
  static constexpr uint64_t kPrime = 1099511628211U;

  void AddByte(uint8_t byte) { value_ = (value_ ^ byte) * kPrime; }
  void AddNumber(uint32_t number);

  uint64_t value_ = kOffsetBasis;
};

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_FINGERPRINT_H_
