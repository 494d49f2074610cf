#ifndef PROTO_ENGINE_ENUMS_H_
#define PROTO_ENGINE_ENUMS_H_

#include <cstddef>
#include <utility>

#include "envcore/pool/pool.h"
#include "procgen/v1/pools.pb.h"

namespace procgen {

// The values of an API enum other than UNSPECIFIED with those of the engine, the default first.
template <typename Enum, typename Value, size_t kCount>
using EnumTable = const std::pair<Enum, Value>[kCount];

inline constexpr std::pair<v1::DistributionMode, DistributionMode> kDistributionModes[] = {
    {v1::DISTRIBUTION_MODE_HARD, DistributionMode::kHard},
    {v1::DISTRIBUTION_MODE_EASY, DistributionMode::kEasy},
    {v1::DISTRIBUTION_MODE_EXTREME, DistributionMode::kExtreme},
    {v1::DISTRIBUTION_MODE_MEMORY, DistributionMode::kMemory},
    {v1::DISTRIBUTION_MODE_EXPLORATION, DistributionMode::kExploration}};
inline constexpr std::pair<v1::AutoresetMode, AutoresetMode> kAutoresetModes[] = {
    {v1::AUTORESET_MODE_SAME_STEP, AutoresetMode::kSameStep},
    {v1::AUTORESET_MODE_NEXT_STEP, AutoresetMode::kNextStep},
    {v1::AUTORESET_MODE_DISABLED, AutoresetMode::kDisabled}};
inline constexpr std::pair<v1::Color, Color> kColors[] = {{v1::COLOR_RGB, Color::kRgb},
                                                          {v1::COLOR_GRAYSCALE, Color::kGrayscale}};
inline constexpr std::pair<v1::Layout, Layout> kLayouts[] = {{v1::LAYOUT_HWC, Layout::kHwc},
                                                             {v1::LAYOUT_CHW, Layout::kChw}};

// Returns the API's value; UNSPECIFIED: there is none.
template <typename Enum, typename Value, size_t kCount>
Enum EnumOf(EnumTable<Enum, Value, kCount>& table, Value given) {
  for (const auto& [known, value] : table) {
    if (given == value) {
      return known;
    }
  }
  return Enum();
}

}  // namespace procgen

#endif  // PROTO_ENGINE_ENUMS_H_
