#ifndef SERVER_POOL_RAND_SEED_H_
#define SERVER_POOL_RAND_SEED_H_

#include <cstdint>

namespace procgen {

// Returns a random rand_seed in [0, 2^31 - 1), for pools created without one. Threads: any.
int64_t DrawRandSeed();

}  // namespace procgen

#endif  // SERVER_POOL_RAND_SEED_H_
