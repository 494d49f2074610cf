#include "envcore/environment/environment_options.h"

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "envcore/games/game_catalog.h"
#include "envcore/status/status.h"

namespace procgen {
namespace {

std::string GameNames() {
  std::vector<absl::string_view> names;
  for (const GameSpec& game : GameCatalog()) {
    names.push_back(game.name);
  }
  return absl::StrJoin(names, ", ");
}

std::string ModesOf(const GameSpec& game) {
  std::vector<absl::string_view> names;
  for (const DistributionMode mode : game.modes) {
    names.push_back(DistributionModeName(mode));
  }
  if (game.exploration_level.has_value()) {
    names.push_back(DistributionModeName(DistributionMode::kExploration));
  }
  return absl::StrJoin(names, ", ");
}

Status CheckNotNegative(absl::string_view option, int32_t value) {
  if (value < 0) {
    return InvalidArgumentError(absl::StrCat(option, " is ", value, ", must be at least 0"));
  }
  return OkStatus();
}

// Whether the variant, if any, is of the game.
Status CheckVariant(absl::string_view game, Variant variant) {
  std::vector<absl::string_view> names;
  for (const VariantSpec& spec : VariantCatalog()) {
    if (spec.game == game) {
      names.push_back(spec.name);
      if (spec.variant == variant) {
        return OkStatus();
      }
    }
  }
  if (variant == Variant::kNone) {
    return OkStatus();
  }
  return InvalidArgumentError(
      absl::StrCat("variant is ", VariantName(variant), ", ", game, " has ",
                   names.empty() ? "no variants" : absl::StrJoin(names, ", ")));
}

}  // namespace

StatusOr<const GameSpec*> RequireGame(absl::string_view name) {
  const GameSpec* spec = FindGame(name);
  if (spec == nullptr) {
    return NotFoundError(absl::StrCat("no game is named \"", name, "\"; there are ", GameNames()));
  }
  return spec;
}

StatusOr<Variant> RequireVariant(absl::string_view name) {
  const std::optional<Variant> variant = FindVariant(name);
  if (!variant.has_value()) {
    return InvalidArgumentError(absl::StrCat(
        "variant is ", name, ", must be one of ",
        absl::StrJoin(VariantCatalog(), ", ", [](std::string* text, const VariantSpec& spec) {
          absl::StrAppend(text, spec.name, " (", spec.game, ")");
        })));
  }
  return *variant;
}

StatusOr<EnvironmentOptions> ResolveOptions(absl::string_view game,
                                            const EnvironmentOptions& options) {
  const StatusOr<const GameSpec*> found = RequireGame(game);
  if (!found.ok()) {
    return found.status();
  }
  const GameSpec* const spec = *found;
  if (!spec->HasMode(options.distribution_mode)) {
    return InvalidArgumentError(absl::StrCat(
        "distribution_mode is ", DistributionModeName(options.distribution_mode), " (",
        static_cast<int32_t>(options.distribution_mode), "), ", game, " has ", ModesOf(*spec)));
  }
  for (const Status& status : {CheckNotNegative("num_levels", options.num_levels),
                               CheckNotNegative("start_level", options.start_level),
                               CheckVariant(game, options.variant)}) {
    if (!status.ok()) {
      return status;
    }
  }
  EnvironmentOptions resolved = options;
  if (options.distribution_mode == DistributionMode::kExploration) {
    if (options.num_levels != 0 || options.start_level != 0) {
      return InvalidArgumentError(
          absl::StrCat("distribution_mode exploration plays one level of its own: num_levels and "
                       "start_level must be 0, are ",
                       options.num_levels, " and ", options.start_level));
    }
    resolved.distribution_mode = DistributionMode::kHard;
    resolved.num_levels = 1;
    resolved.start_level = *spec->exploration_level;
  }
  return resolved;
}

}  // namespace procgen
