#ifndef ENVCORE_POOL_POOL_INPUT_H_
#define ENVCORE_POOL_POOL_INPUT_H_

#include <cstddef>
#include <cstdint>

#include "envcore/pool/pool.h"
#include "envcore/status/status.h"

namespace procgen {

// Checks `options`, except what depends on the game (see ResolveOptions). Errors: INVALID_ARGUMENT
// (the message gives the value and what is allowed).
Status CheckPoolOptions(const PoolOptions& options);

// Checks a step of a pool of `env_count` environments with observations of `observation_bytes`.
// Errors: as CheckPoolOptions.
Status CheckStep(const StepInput& input, const Batch& batch, int32_t env_count,
                 size_t observation_bytes);

}  // namespace procgen

#endif  // ENVCORE_POOL_POOL_INPUT_H_
