#ifndef TESTS_CONFORMANCE_DM_ENV_RPC_PLAYER_H_
#define TESTS_CONFORMANCE_DM_ENV_RPC_PLAYER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "envcore/trace/trace.h"
#include "tools/conformance/player.h"

namespace procgen {

// Both play through dm_env_rpc on the server at `address`, which draws with its own art. Errors:
// those of the server.

// All environments as one batched world.
absl::StatusOr<std::unique_ptr<Player>> MakeBatchedWorldPlayer(const Trace& trace,
                                                               const std::string& address,
                                                               bool with_pictures);
// Each environment as a separate world. REQUIRES: no action of the trace is -1.
absl::StatusOr<std::unique_ptr<Player>> MakeSingleWorldsPlayer(const Trace& trace,
                                                               const std::string& address,
                                                               bool with_pictures);

}  // namespace procgen

#endif  // TESTS_CONFORMANCE_DM_ENV_RPC_PLAYER_H_
