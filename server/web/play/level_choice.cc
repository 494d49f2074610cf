#include "server/web/play/level_choice.h"

#include <algorithm>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

// The mode of a game by name. Returns null and reports an error if there is none.
const v1::GameMode* FindMode(const v1::Game& game, const std::string& name, RequestParams* params) {
  std::vector<std::string> names;
  for (const v1::GameMode& mode : game.modes()) {
    if (ModeName(mode.distribution_mode()) == name) {
      return &mode;
    }
    names.push_back(ModeName(mode.distribution_mode()));
  }
  params->Choice("mode", names);
  return nullptr;
}

// Sets an option by name, validated against the catalog.
void SetOption(const v1::Option& option, const Json& value, v1::EnvironmentOptions* options,
               RequestParams* params) {
  const google::protobuf::FieldDescriptor* const field =
      v1::EnvironmentOptions::descriptor()->FindFieldByName(option.name());
  if (option.type() == v1::OPTION_TYPE_BOOLEAN) {
    if (!value.is_boolean()) {
      params->Refuse(absl::StrCat("options.", option.name(), " is not a boolean"));
      return;
    }
    v1::EnvironmentOptions::GetReflection()->SetBool(options, field, value.get<bool>());
    return;
  }
  const Json member = {{option.name(), value}};
  RequestParams integer(member);
  const int64_t number = integer.Integer(option.name(), option.min(), option.max());
  if (absl::Status status = integer.CheckAll(); !status.ok()) {
    params->Refuse(absl::StrCat("options.", status.message()));
    return;
  }
  v1::EnvironmentOptions::GetReflection()->SetInt32(options, field, static_cast<int32_t>(number));
}

void SetOptions(const v1::Catalog& catalog, const Json& given, v1::EnvironmentOptions* options,
                RequestParams* params) {
  for (const auto& [name, value] : given.items()) {
    const auto option =
        std::find_if(catalog.options().begin(), catalog.options().end(),
                     [&name = name](const v1::Option& known) { return known.name() == name; });
    if (option == catalog.options().end() || IsChosenOtherwise(name)) {
      params->Refuse(absl::StrCat("options has a member that is none of the catalog's options",
                                  ", or that other members determine"));
      return;
    }
    SetOption(*option, value, options, params);
  }
}

}  // namespace

std::string ModeName(v1::DistributionMode mode) {
  const std::string& name = v1::DistributionMode_Name(mode);
  return absl::AsciiStrToLower(absl::StripPrefix(name, "DISTRIBUTION_MODE_"));
}

bool IsChosenOtherwise(const std::string& option) {
  return option == "distribution_mode" || option == "num_levels" || option == "start_level" ||
         option == "rand_seed";
}

LevelChoice ReadLevelChoice(const v1::Catalog& catalog, const std::string& seed_member,
                            RequestParams* params) {
  LevelChoice choice;
  std::vector<std::string> games;
  for (const v1::Game& game : catalog.games()) {
    games.push_back(game.name());
  }
  choice.game = params->Choice("game", games);
  const auto game =
      std::find_if(catalog.games().begin(), catalog.games().end(),
                   [&choice](const v1::Game& known) { return known.name() == choice.game; });
  const v1::GameMode* const mode = FindMode(*game, params->Text("mode"), params);
  SetOptions(catalog, params->ObjectOr("options"), &choice.options, params);
  if (mode == nullptr) {
    return choice;
  }
  choice.options.set_distribution_mode(mode->distribution_mode());
  if (mode->has_level_seed()) {
    choice.has_one_level = true;
    choice.level_seed = mode->level_seed();
    params->Integer32Or(seed_member, choice.level_seed, choice.level_seed, choice.level_seed);
  } else {
    choice.level_seed = params->Integer32(seed_member, 0, kLevelSeedMax);
  }
  return choice;
}

v1::PoolSpec SpecOf(const LevelChoice& choice) {
  v1::PoolSpec spec;
  spec.add_games(choice.game);
  spec.set_env_count(1);
  *spec.mutable_options() = choice.options;
  spec.mutable_options()->set_rand_seed(0);
  if (!choice.has_one_level) {
    spec.mutable_options()->set_num_levels(1);
    spec.mutable_options()->set_start_level(choice.level_seed);
  }
  return spec;
}

}  // namespace procgen::web
