#include "server/pool/rand_seed.h"

#include <random>

namespace procgen {

int64_t DrawRandSeed() {
  std::random_device device;
  return static_cast<int64_t>(device() % 2147483647U);
}

}  // namespace procgen
