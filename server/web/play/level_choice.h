#ifndef SERVER_WEB_PLAY_LEVEL_CHOICE_H_
#define SERVER_WEB_PLAY_LEVEL_CHOICE_H_

#include <cstdint>
#include <string>

#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/pools.pb.h"
#include "server/web/json/message.h"

namespace procgen::web {

// The largest level seed.
inline constexpr int32_t kLevelSeedMax = 2147483646;

// A level that a page selects.
struct LevelChoice {
  std::string game;
  procgen::v1::EnvironmentOptions options;  // without the options that select levels
  int32_t level_seed = 0;
  bool has_one_level = false;  // exploration mode; the catalog has its seed
};

// Reads the members game, mode, options and `seed_member` of a request. Reports errors to `params`.
LevelChoice ReadLevelChoice(const procgen::v1::Catalog& catalog, const std::string& seed_member,
                            RequestParams* params);

// The spec of a pool of one environment that repeats the level.
procgen::v1::PoolSpec SpecOf(const LevelChoice& choice);

// Returns "easy" for DISTRIBUTION_MODE_EASY.
std::string ModeName(procgen::v1::DistributionMode mode);

// Whether pages may not set an option because other members of the request determine it.
bool IsChosenOtherwise(const std::string& option);

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_LEVEL_CHOICE_H_
