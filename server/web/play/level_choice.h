#ifndef SERVER_WEB_PLAY_LEVEL_CHOICE_H_
#define SERVER_WEB_PLAY_LEVEL_CHOICE_H_

#include <cstdint>
#include <string>

#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/pools.pb.h"
#include "server/web/json/message.h"

namespace procgen::web {

// The largest seed that a level can be begun with.
inline constexpr int32_t kLevelSeedMax = 2147483646;

// Which levels a page wants.
struct LevelChoice {
  std::string game;
  procgen::v1::EnvironmentOptions options;  // without the choice of levels
  int32_t level_seed = 0;
  bool has_one_level = false;  // exploration: the catalog says which
};

// Reads the members game, mode, options and `seed_member` of a request; what is wrong is told to
// `params`.
LevelChoice ReadLevelChoice(const procgen::v1::Catalog& catalog, const std::string& seed_member,
                            RequestParams* params);

// A pool of one environment that plays that level, again and again.
procgen::v1::PoolSpec SpecOf(const LevelChoice& choice);

// "easy" of DISTRIBUTION_MODE_EASY.
std::string ModeName(procgen::v1::DistributionMode mode);

// The options that pages may not set, because other members of their requests say them.
bool IsChosenOtherwise(const std::string& option);

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_LEVEL_CHOICE_H_
