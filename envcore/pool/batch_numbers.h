#ifndef ENVCORE_POOL_BATCH_NUMBERS_H_
#define ENVCORE_POOL_BATCH_NUMBERS_H_

#include <cstdint>
#include <vector>

#include "envcore/pool/pool.h"

namespace procgen {

// Buffers for all arrays of a Batch except the observations. Batch documents each array.
struct BatchNumbers {
#define PROCGEN_MEMBER(type, name, member) std::vector<type> name;
  PROCGEN_BATCH_NUMBERS(PROCGEN_MEMBER)
#undef PROCGEN_MEMBER

  // Returns `batch`, of `count` environments, with each empty array replaced by a buffer of this
  // object. The buffers keep their values between calls. The returned spans are valid until the
  // next call.
  Batch ReplaceEmptyArrays(Batch batch, int32_t count);

  bool operator==(const BatchNumbers& other) const = default;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_BATCH_NUMBERS_H_
