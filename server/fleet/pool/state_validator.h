#ifndef SERVER_FLEET_POOL_STATE_VALIDATOR_H_
#define SERVER_FLEET_POOL_STATE_VALIDATOR_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "envcore/pool/pool.h"
#include "procgen/v1/states.pb.h"

namespace procgen {

// Restores states in a small local pool, one environment of each game, to check whether nodes will
// accept them. Threads: compatible.
class StateValidator {
 public:
  // Errors: those of Pool::Create for `options`, with the same messages.
  static absl::StatusOr<StateValidator> Create(const PoolOptions& options);

  // Checks states for a pool with those options, and sets `awaits_reset` ([N]) to its value after a
  // restore. Errors: those of Pool::RestoreStates; then `awaits_reset` is unchanged.
  absl::Status Check(const std::vector<v1::State>& states, std::vector<bool>* awaits_reset);

 private:
  StateValidator(int32_t first_env, std::unique_ptr<Pool> model)
      : first_env_(first_env), model_(std::move(model)) {}

  int32_t first_env_;
  std::unique_ptr<Pool> model_;
};

// Errors: INVALID_ARGUMENT `environment` is not in [0, env_count).
absl::Status CheckEnvironment(int32_t environment, int32_t env_count);

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_STATE_VALIDATOR_H_
