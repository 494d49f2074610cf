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

// Options of the pool of a new world.
struct WorldOptions {
  std::string pool_id;  // empty: the server chooses a number
  PoolOptions pool_options;
  SessionOptions session_options;
};

// Parses the settings of a new world; README.md lists them. Without `num_envs` the world is a
// single environment with AutoresetMode::kDisabled; with it, a batch. The engine validates its own
// options. Errors: INVALID_ARGUMENT a setting is missing or unknown, or has a wrong type or value;
// RESOURCE_EXHAUSTED the lease is longer than the limit.
absl::StatusOr<WorldOptions> ReadWorldSettings(const Settings& settings, const Limits& limits);

// Settings of the next episodes. An empty optional: not set.
struct EpisodeSettings {
  std::vector<std::optional<int32_t>> level_seeds;  // [N]
  std::vector<std::optional<int64_t>> rand_seeds;   // new seeds of the choice of levels [N]
};

// Parses the settings of a reset. `shape`: that of one value per environment. A scalar for a batch
// is the level of all environments, or the rand_seed of the first; the others get successive ones.
// Errors: INVALID_ARGUMENT.
absl::StatusOr<EpisodeSettings> ReadEpisodeSettings(const Settings& settings, TensorShape shape);

// Checks that `request`, which has no settings, got none. Errors: INVALID_ARGUMENT it got one.
absl::Status CheckNoSettings(absl::string_view request, const Settings& settings);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_WORLD_SETTINGS_H_
