#include "clients/libenv/tensor_types.h"

#include <algorithm>
#include <initializer_list>
#include <limits>

#include "absl/strings/string_view.h"
#include "envcore/pool/pool.h"

namespace procgen {
namespace {

LibenvTensorType Discrete(absl::string_view name, LibenvValueType value_type,
                          std::initializer_list<int> shape) {
  LibenvTensorType type = {};
  std::copy(name.begin(), name.end(), type.name);
  type.scalar_type = kLibenvDiscrete;
  type.value_type = value_type;
  std::copy(shape.begin(), shape.end(), type.shape);
  type.dimension_count = static_cast<int>(shape.size());
  return type;
}

LibenvTensorType Uint8(absl::string_view name, std::initializer_list<int> shape, uint8_t high) {
  LibenvTensorType type = Discrete(name, kLibenvUint8, shape);
  type.high.uint8 = high;
  return type;
}

LibenvTensorType Int32(absl::string_view name, int32_t high) {
  LibenvTensorType type = Discrete(name, kLibenvInt32, {});
  type.high.int32 = high;
  return type;
}

}  // namespace

std::vector<LibenvTensorType> TensorTypesOf(int space, int32_t num_actions, bool render_human) {
  constexpr uint8_t kColourMax = std::numeric_limits<uint8_t>::max();
  constexpr int32_t kSeedMax = std::numeric_limits<int32_t>::max();
  switch (space) {
    case kLibenvObservation:
      return {Uint8("rgb", {kObservationSizePx, kObservationSizePx, 3}, kColourMax)};
    case kLibenvAction:
      return {Int32("action", num_actions - 1)};
    case kLibenvInfo: {
      std::vector<LibenvTensorType> infos = {Int32("prev_level_seed", kSeedMax),
                                             Uint8("prev_level_complete", {}, 1),
                                             Int32("level_seed", kSeedMax)};
      if (render_human) {
        infos.push_back(Uint8("rgb", {kHumanViewSizePx, kHumanViewSizePx, 3}, kColourMax));
      }
      return infos;
    }
    default:
      return {};
  }
}

}  // namespace procgen
