#ifndef ENVCORE_ENVIRONMENT_FINGERPRINT_H_
#define ENVCORE_ENVIRONMENT_FINGERPRINT_H_

#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"
#include "envcore/environment/environment_options.h"

namespace procgen {

// A running hash of an episode. Equal fingerprints mean, up to hash collisions, equal game,
// options, levels, actions, rewards and episode end. It is the 64-bit FNV-1a hash of the bytes
// below. Numbers are little-endian, 32 bits; one-byte values are 0 or 1.
//
//   begin  name of the game, byte 0, distribution_mode, debug_mode, then one byte each:
//          center_agent, use_backgrounds, use_generated_assets, use_monochrome_assets,
//          restrict_themes, paint_vel_info, use_sequential_levels; with a variant: 'V', variant
//   level  'L', level seed                                        at the beginning of each level
//   step   'S', action (-1 included), bits of the reward (f32), flags            after each step
//          flags: 1 the level was completed + 2 terminated + 4 truncated
//   edit   'E', CRC-32 of the state                       when the state was changed by hand
//
// FNV-1a: h = 14695981039346656037; for each byte b: h = (h xor b) * 1099511628211 modulo 2^64.
// Each repetition of an action counts as a step. The autoreset mode is not hashed.
class Fingerprint {
 public:
  Fingerprint() = default;

  void Begin(absl::string_view game, const EnvironmentOptions& options);
  void AddLevel(int32_t level_seed);
  void AddEdit(uint32_t checksum);
  void AddStep(int32_t action, float reward, bool level_complete, bool terminated, bool truncated);

  uint64_t value() const { return value_; }
  // Continues from an earlier value().
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
