#include "envcore/environment/environment_options.h"

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

// Whether the variant, if any, is of the game, and its value in range.
Status CheckVariant(absl::string_view game, const GameOptions& options) {
  if (options.variant == Variant::kNone && options.variant_value == 0) {
    return OkStatus();
  }
  const std::string text = VariantText(options.variant, options.variant_value);
  const VariantSpec* const found = FindVariant(game, options.variant);
  if (found != nullptr) {
    const float low = found->value / kVariantValueFactor;
    const float high = found->value * kVariantValueFactor;
    if (options.variant_value >= low && options.variant_value <= high) {
      return OkStatus();
    }
    return InvalidArgumentError(absl::StrCat("variant is ", text, ", the value of ", game,
                                             " is in [", low, ", ", high, "]"));
  }
  std::vector<std::string> texts;
  for (const VariantSpec& spec : VariantCatalog()) {
    if (spec.game == game) {
      texts.push_back(VariantText(spec));
    }
  }
  return InvalidArgumentError(
      absl::StrCat("variant is ", text, ", ", game, " has ",
                   texts.empty() ? "no variants" : absl::StrJoin(texts, ", ")));
}

}  // namespace

StatusOr<const GameSpec*> RequireGame(absl::string_view name) {
  const GameSpec* spec = FindGame(name);
  if (spec == nullptr) {
    return NotFoundError(absl::StrCat("no game is named \"", name, "\"; there are ", GameNames()));
  }
  return spec;
}

Status RequireVariant(absl::string_view text, GameOptions* options) {
  if (SetVariant(text, options)) {
    return OkStatus();
  }
  return InvalidArgumentError(absl::StrCat(
      "variant is ", text, ", must be one of ",
      absl::StrJoin(VariantCatalog(), ", ", [](std::string* names, const VariantSpec& spec) {
        absl::StrAppend(names, VariantText(spec), " (", spec.game, ")");
      })));
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
  for (const Status& status :
       {CheckNotNegative("num_levels", options.num_levels),
        CheckNotNegative("start_level", options.start_level), CheckVariant(game, options)}) {
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
