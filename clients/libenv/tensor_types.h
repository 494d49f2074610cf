#ifndef CLIENTS_LIBENV_TENSOR_TYPES_H_
#define CLIENTS_LIBENV_TENSOR_TYPES_H_

#include <cstdint>
#include <vector>

#include "clients/libenv/libenv.h"

namespace procgen {

// Side of the human view in the infos, in pixels, and its bytes: uint8 [512, 512, 3].
inline constexpr int32_t kHumanViewSizePx = 512;
inline constexpr int32_t kHumanViewBytes = kHumanViewSizePx * kHumanViewSizePx * 3;

// Members of the info space, by index.
enum InfoMember {
  kInfoPrevLevelSeed = 0,
  kInfoPrevLevelComplete = 1,
  kInfoLevelSeed = 2,
  kInfoHumanView = 3,
};

// Returns the members of a LibenvSpace, in order; empty for other values.
std::vector<LibenvTensorType> TensorTypesOf(int space, int32_t num_actions, bool render_human);

}  // namespace procgen

#endif  // CLIENTS_LIBENV_TENSOR_TYPES_H_
