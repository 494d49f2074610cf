#include "clients/c/catalog_json.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "envcore/games/game_catalog.h"
#include "envcore/games/game_variants.h"
#include "nlohmann/json.hpp"

namespace procgen_client {
namespace {

using nlohmann::ordered_json;

ordered_json ModeOf(const procgen::GameSpec& game, procgen::DistributionMode mode) {
  ordered_json json = {{"time_limit_steps", game.StepLimit(mode)}, {"return_range", nullptr}};
  if (mode == procgen::DistributionMode::kEasy) {
    json["return_range"] = {game.easy_returns.min, game.easy_returns.max};
  } else if (mode == procgen::DistributionMode::kHard) {
    json["return_range"] = {game.hard_returns.min, game.hard_returns.max};
  } else if (mode == procgen::DistributionMode::kExploration) {
    json["level_seed"] = *game.exploration_level;
  }
  return json;
}

ordered_json GameOf(const procgen::GameSpec& game) {
  ordered_json modes = ordered_json::object();
  for (const procgen::DistributionMode mode : game.modes) {
    modes[std::string(procgen::DistributionModeName(mode))] = ModeOf(game, mode);
  }
  if (game.exploration_level.has_value()) {
    modes["exploration"] = ModeOf(game, procgen::DistributionMode::kExploration);
  }
  ordered_json special_actions = ordered_json::object();
  for (const procgen::SpecialAction& special : game.special_actions) {
    special_actions[absl::StrCat(special.action)] = std::string(special.description);
  }
  ordered_json kinds = ordered_json::array();
  for (const auto named : {procgen::CommonKindNames(), game.kinds}) {
    for (const procgen::KindName& kind : named) {
      kinds.push_back(
          {{"kind", kind.kind}, {"name", std::string(kind.name)}, {"is_goal", kind.is_goal}});
    }
  }
  ordered_json variants = ordered_json::object();
  for (const procgen::VariantSpec& variant : procgen::VariantCatalog()) {
    if (variant.game == game.name) {
      variants[procgen::VariantText(variant)] = std::string(variant.description);
    }
  }
  return {{"name", std::string(game.name)},
          {"description", std::string(game.description)},
          {"modes", modes},
          {"special_actions", special_actions},
          {"kinds", kinds},
          {"variants", variants}};
}

}  // namespace

std::string CatalogJson() {
  ordered_json actions = ordered_json::array();
  for (int32_t number = 0; number < procgen::kActionCount; ++number) {
    const std::string name(procgen::ActionName(number));
    ordered_json keys = ordered_json::array();
    if (number != procgen::kNoAction) {
      keys = std::vector<std::string>(absl::StrSplit(name, '+'));
    }
    actions.push_back({{"name", name}, {"keys", keys}});
  }
  ordered_json games = ordered_json::array();
  for (const procgen::GameSpec& game : procgen::GameCatalog()) {
    games.push_back(GameOf(game));
  }
  return ordered_json{{"actions", actions}, {"games", games}}.dump();
}

}  // namespace procgen_client
