#ifndef SERVER_DM_ENV_RPC_WORLD_SETTINGS_H_
#define SERVER_DM_ENV_RPC_WORLD_SETTINGS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "envcore/pool/pool.h"
#include "google/protobuf/map.h"
#include "server/dm_env_rpc/tensor.h"
#include "server/session/pool_supervisor.h"
#include "server/session/quota/limits.h"

namespace procgen {

// Settings of a request, by name.
using Settings = google::protobuf::Map<std::string, dm::Tensor>;

// What a world is made of: a pool.
struct WorldPlan {
  std::string pool_id;  // empty: a number is chosen
  PoolOptions options;
  SessionOptions session_options;
};

// Reads the settings of a new world; README.md lists them. Without `num_envs` it is a single
// environment, whose episodes end by the protocol's states; with it, a batch. Errors:
// INVALID_ARGUMENT one that is missing, unknown, or of another type or value; RESOURCE_EXHAUSTED a
// lease longer than the limit. What concerns the engine is checked there.
absl::StatusOr<WorldPlan> ReadWorldSettings(const Settings& settings, const Limits& limits);

// What is asked of the episodes that begin next.
struct EpisodeSettings {
  std::vector<std::optional<int32_t>> level_seeds;  // the levels to play [N]
  std::vector<std::optional<int64_t>> rand_seeds;   // seed the choice of levels anew [N]
};

// Reads the settings of a reset. `shape`: of values for each environment. Errors: INVALID_ARGUMENT.
absl::StatusOr<EpisodeSettings> ReadEpisodeSettings(const Settings& settings, TensorShape shape);

// There are no settings. Errors: INVALID_ARGUMENT there are, of `request`.
absl::Status CheckNoSettings(absl::string_view request, const Settings& settings);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_WORLD_SETTINGS_H_
