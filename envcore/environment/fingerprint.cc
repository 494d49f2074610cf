#include "envcore/environment/fingerprint.h"

#include <bit>

namespace procgen {

void Fingerprint::Begin(absl::string_view game, const EnvironmentOptions& options) {
  value_ = kOffsetBasis;
  for (const char letter : game) {
    AddByte(static_cast<uint8_t>(letter));
  }
  AddByte(0);
  AddNumber(static_cast<uint32_t>(options.distribution_mode));
  AddNumber(static_cast<uint32_t>(options.debug_mode));
  for (const bool option :
       {options.center_agent, options.use_backgrounds, options.use_generated_assets,
        options.use_monochrome_assets, options.restrict_themes, options.paint_vel_info,
        options.use_sequential_levels}) {
    AddByte(option ? 1 : 0);
  }
  if (options.variant != Variant::kNone) {
    AddByte('V');
    AddNumber(static_cast<uint32_t>(options.variant));
    if (options.variant_value != 0) {
      AddNumber(std::bit_cast<uint32_t>(options.variant_value));
    }
  }
}

void Fingerprint::AddEdit(uint32_t checksum) {
  AddByte('E');
  AddNumber(checksum);
}

void Fingerprint::AddLevel(int32_t level_seed) {
  AddByte('L');
  AddNumber(static_cast<uint32_t>(level_seed));
}

void Fingerprint::AddStep(int32_t action, float reward, bool level_complete, bool terminated,
                          bool truncated) {
  AddByte('S');
  AddNumber(static_cast<uint32_t>(action));
  AddNumber(std::bit_cast<uint32_t>(reward));
  AddByte(
      static_cast<uint8_t>((level_complete ? 1 : 0) + (terminated ? 2 : 0) + (truncated ? 4 : 0)));
}

void Fingerprint::AddNumber(uint32_t number) {
  for (int shift = 0; shift < 32; shift += 8) {
    AddByte(static_cast<uint8_t>(number >> shift));
  }
}

}  // namespace procgen
