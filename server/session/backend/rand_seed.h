#ifndef SERVER_SESSION_BACKEND_RAND_SEED_H_
#define SERVER_SESSION_BACKEND_RAND_SEED_H_

#include <cstdint>

namespace procgen {

// A rand_seed for who has given none, in [0, 2^31 - 1). Threads: from any thread.
int64_t DrawRandSeed();

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_RAND_SEED_H_
