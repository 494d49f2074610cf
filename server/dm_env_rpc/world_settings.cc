#include "server/dm_env_rpc/world_settings.h"

#include <algorithm>
#include <array>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "server/session/backend/rand_seed.h"

namespace procgen {
namespace {

constexpr size_t kGamesMax = 64;
constexpr size_t kGameBytesMax = 64;  // largest size of a game's name

constexpr size_t kPoolIdBytesMax = 63;

// A setting of a new world: its name, and the function that parses it.
struct WorldSetting {
  absl::string_view name;
  absl::Status (*read)(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options);
};

absl::Status ReadGames(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options) {
  absl::StatusOr<std::vector<std::string>> games = ReadTexts(name, tensor);
  if (!games.ok()) {
    return games.status();
  }
  if (games->empty() || games->size() > kGamesMax) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " has ", games->size(), " games, allowed: 1 to ", kGamesMax));
  }
  for (const std::string& game : *games) {
    if (game.size() > kGameBytesMax) {
      return absl::InvalidArgumentError(absl::StrCat(name, " is '", Truncated(game),
                                                     "', allowed: the name of a game, at most ",
                                                     kGameBytesMax, " characters"));
    }
  }
  options->pool_options.games = *std::move(games);
  return absl::OkStatus();
}

// Parses an integer in [min, max] into `value`.
template <typename Integer>
absl::Status ReadIntegerTo(absl::string_view name, const dm::Tensor& tensor, int64_t min,
                           int64_t max, Integer* value) {
  const absl::StatusOr<int64_t> read = ReadInteger(name, tensor, min, max);
  if (read.ok()) {
    *value = static_cast<Integer>(*read);
  }
  return read.status();
}

// `option`, here and below: the member of EnvironmentOptions or of PoolOptions to set.
template <auto option>
absl::Status ReadCount(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options) {
  return ReadIntegerTo(name, tensor, 0, INT32_MAX, &(options->pool_options.environment.*option));
}

template <auto option, int32_t min>
absl::Status ReadPoolOption(absl::string_view name, const dm::Tensor& tensor,
                            WorldOptions* options) {
  return ReadIntegerTo(name, tensor, min, INT32_MAX, &(options->pool_options.*option));
}

template <auto option>
absl::Status ReadFlag(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options) {
  const absl::StatusOr<bool> read = ReadBool(name, tensor);
  if (read.ok()) {
    options->pool_options.environment.*option = *read;
  }
  return read.status();
}

absl::Status ReadMode(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options) {
  constexpr std::array kModes = {DistributionMode::kEasy, DistributionMode::kHard,
                                 DistributionMode::kExtreme, DistributionMode::kMemory,
                                 DistributionMode::kExploration};
  std::string given;
  std::optional<DistributionMode> mode;
  if (tensor.has_strings()) {
    const absl::StatusOr<std::string> text = ReadText(name, tensor);
    if (!text.ok()) {
      return text.status();
    }
    given = absl::StrCat("'", Truncated(*text), "'");
    mode = FindDistributionMode(*text);
  } else {
    const absl::StatusOr<int64_t> number = ReadInteger(name, tensor, INT64_MIN, INT64_MAX);
    if (!number.ok()) {
      return number.status();
    }
    given = absl::StrCat(*number);
    const auto* const found = std::find_if(
        kModes.begin(), kModes.end(),
        [&](DistributionMode known) { return static_cast<int64_t>(known) == *number; });
    mode = found == kModes.end() ? std::nullopt : std::optional(*found);
  }
  if (!mode.has_value()) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, " is ", given,
        ", allowed: ", absl::StrJoin(kModes, ", ", [](std::string* out, DistributionMode known) {
          absl::StrAppend(out, "'", DistributionModeName(known), "' (", static_cast<int>(known),
                          ")");
        })));
  }
  options->pool_options.environment.distribution_mode = *mode;
  return absl::OkStatus();
}

absl::Status ReadRandSeed(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options) {
  return ReadIntegerTo(name, tensor, INT64_MIN, INT64_MAX,
                       &options->pool_options.environment.rand_seed);
}

absl::Status ReadDebugMode(absl::string_view name, const dm::Tensor& tensor,
                           WorldOptions* options) {
  return ReadIntegerTo(name, tensor, INT32_MIN, INT32_MAX,
                       &options->pool_options.environment.debug_mode);
}

absl::Status ReadEnvCount(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options) {
  options->pool_options.autoreset_mode = AutoresetMode::kSameStep;
  return ReadIntegerTo(name, tensor, 1, INT32_MAX, &options->pool_options.env_count);
}

absl::Status ReadScreenSize(absl::string_view name, const dm::Tensor& tensor,
                            WorldOptions* options) {
  return ReadIntegerTo(name, tensor, kObservationSizePxMin, kObservationSizePxMax,
                       &options->pool_options.observation_format.frame.size_px);
}

absl::Status ReadGrayscale(absl::string_view name, const dm::Tensor& tensor,
                           WorldOptions* options) {
  const absl::StatusOr<bool> read = ReadBool(name, tensor);
  if (read.ok()) {
    options->pool_options.observation_format.frame.color = *read ? Color::kGrayscale : Color::kRgb;
  }
  return read.status();
}

absl::Status ReadLayout(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options) {
  const absl::StatusOr<std::string> text = ReadText(name, tensor);
  if (!text.ok()) {
    return text.status();
  }
  if (*text != "hwc" && *text != "chw") {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " is '", Truncated(*text), "', allowed: 'hwc', 'chw'"));
  }
  options->pool_options.observation_format.frame.layout =
      *text == "hwc" ? Layout::kHwc : Layout::kChw;
  return absl::OkStatus();
}

absl::Status ReadFrameStack(absl::string_view name, const dm::Tensor& tensor,
                            WorldOptions* options) {
  return ReadIntegerTo(name, tensor, 1, kFrameStackMax,
                       &options->pool_options.observation_format.frame_stack);
}

absl::Status ReadLeaseDuration(absl::string_view name, const dm::Tensor& tensor,
                               WorldOptions* options) {
  const absl::StatusOr<double> seconds = ReadNumber(name, tensor);
  if (seconds.ok()) {
    options->session_options.lease_duration =
        *seconds == 0 ? absl::InfiniteDuration() : absl::Seconds(*seconds);
  }
  return seconds.status();
}

absl::Status ReadPoolId(absl::string_view name, const dm::Tensor& tensor, WorldOptions* options) {
  absl::StatusOr<std::string> text = ReadText(name, tensor);
  if (!text.ok()) {
    return text.status();
  }
  if (text->empty() || text->size() > kPoolIdBytesMax) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, " is '", Truncated(*text), "', allowed: 1 to ", kPoolIdBytesMax, " characters"));
  }
  options->pool_id = *std::move(text);
  return absl::OkStatus();
}

constexpr absl::string_view kEnvName = "env_name";
constexpr absl::string_view kRandSeed = "rand_seed";
constexpr absl::string_view kLeaseDuration = "lease_duration";
constexpr absl::string_view kLevelSeed = "level_seed";

constexpr WorldSetting kWorldSettings[] = {
    {kEnvName, ReadGames},
    {"num_envs", ReadEnvCount},
    {"distribution_mode", ReadMode},
    {"num_levels", ReadCount<&EnvironmentOptions::num_levels>},
    {"start_level", ReadCount<&EnvironmentOptions::start_level>},
    {kRandSeed, ReadRandSeed},
    {"use_sequential_levels", ReadFlag<&EnvironmentOptions::use_sequential_levels>},
    {"center_agent", ReadFlag<&EnvironmentOptions::center_agent>},
    {"use_backgrounds", ReadFlag<&EnvironmentOptions::use_backgrounds>},
    {"use_generated_assets", ReadFlag<&EnvironmentOptions::use_generated_assets>},
    {"use_monochrome_assets", ReadFlag<&EnvironmentOptions::use_monochrome_assets>},
    {"restrict_themes", ReadFlag<&EnvironmentOptions::restrict_themes>},
    {"paint_vel_info", ReadFlag<&EnvironmentOptions::paint_vel_info>},
    {"debug_mode", ReadDebugMode},
    {"screen_size", ReadScreenSize},
    {"grayscale_obs", ReadGrayscale},
    {"layout", ReadLayout},
    {"frame_stack", ReadFrameStack},
    {"first_env", ReadPoolOption<&PoolOptions::first_env, 0>},
    {"total_env_count", ReadPoolOption<&PoolOptions::total_env_count, 1>},
    {kLeaseDuration, ReadLeaseDuration},
    {"pool_id", ReadPoolId},
};

absl::Status UnknownSetting(absl::string_view name, absl::string_view allowed) {
  return absl::InvalidArgumentError(
      absl::StrCat("there is no setting '", Truncated(name), "', allowed: ", allowed));
}

// Checks what depends on several settings.
absl::Status CheckWorldOptions(const Settings& settings, const WorldOptions& options,
                               const Limits& limits) {
  if (options.pool_options.games.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("settings have no ", kEnvName, ", required: the name of a game"));
  }
  const int64_t least_total =
      int64_t{options.pool_options.first_env} + int64_t{options.pool_options.env_count};
  const int32_t total = options.pool_options.total_env_count;
  if (least_total > INT32_MAX || (total != 0 && total < least_total)) {
    return absl::InvalidArgumentError(
        absl::StrCat("total_env_count is ", total,
                     ", allowed: first_env + num_envs = ", least_total, " to ", INT32_MAX));
  }
  if (settings.contains(std::string(kLeaseDuration)) &&
      options.session_options.lease_duration != absl::InfiniteDuration()) {
    return CheckLeaseDuration(kLeaseDuration, options.session_options.lease_duration, limits);
  }
  return absl::OkStatus();
}

// Reads the levels of all environments. A scalar is the level of each.
absl::Status ReadLevelSeeds(absl::string_view name, const dm::Tensor& tensor, TensorShape given,
                            std::vector<std::optional<int32_t>>* level_seeds) {
  const absl::StatusOr<std::vector<int32_t>> levels = ReadIntegersAsInt32s(name, tensor, given);
  if (!levels.ok()) {
    return levels.status();
  }
  for (size_t i = 0; i < level_seeds->size(); ++i) {
    (*level_seeds)[i] = (*levels)[levels->size() == 1 ? 0 : i];
  }
  return absl::OkStatus();
}

// Reads the new seeds of all environments. A scalar is the first of successive seeds.
absl::Status ReadRandSeeds(absl::string_view name, const dm::Tensor& tensor, TensorShape given,
                           std::vector<std::optional<int64_t>>* rand_seeds) {
  const absl::StatusOr<std::vector<int64_t>> seeds = ReadIntegers(name, tensor, given);
  if (!seeds.ok()) {
    return seeds.status();
  }
  for (size_t i = 0; i < rand_seeds->size(); ++i) {
    const bool is_first = seeds->size() == 1;
    const auto seed = static_cast<uint64_t>((*seeds)[is_first ? 0 : i]);
    // May wrap: the engine uses it modulo 2^32.
    (*rand_seeds)[i] = static_cast<int64_t>(seed + (is_first ? i : 0));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<WorldOptions> ReadWorldSettings(const Settings& settings, const Limits& limits) {
  WorldOptions options;
  options.session_options.lease_duration = limits.lease_duration_default;
  options.pool_options.env_count = 1;
  options.pool_options.autoreset_mode = AutoresetMode::kDisabled;
  for (const auto& [name, tensor] : settings) {
    const absl::string_view given = name;
    const auto* const known =
        std::find_if(std::begin(kWorldSettings), std::end(kWorldSettings),
                     [&](const WorldSetting& setting) { return setting.name == given; });
    if (known == std::end(kWorldSettings)) {
      return UnknownSetting(given, absl::StrJoin(kWorldSettings, ", ",
                                                 [](std::string* out, const WorldSetting& setting) {
                                                   absl::StrAppend(out, setting.name);
                                                 }));
    }
    if (absl::Status status = known->read(known->name, tensor, &options); !status.ok()) {
      return status;
    }
  }
  if (absl::Status status = CheckWorldOptions(settings, options, limits); !status.ok()) {
    return status;
  }
  if (!settings.contains(std::string(kRandSeed))) {
    options.pool_options.environment.rand_seed = DrawRandSeed();
  }
  return options;
}

absl::StatusOr<EpisodeSettings> ReadEpisodeSettings(const Settings& settings, TensorShape shape) {
  const auto env_count = static_cast<size_t>(shape.element_count());
  EpisodeSettings read;
  read.level_seeds.resize(env_count);
  read.rand_seeds.resize(env_count);
  for (const auto& [name, tensor] : settings) {
    const bool is_level = name == kLevelSeed;
    if (!is_level && name != kRandSeed) {
      return UnknownSetting(name, absl::StrCat(kLevelSeed, ", ", kRandSeed));
    }
    const bool for_all = shape.is_list && tensor.shape_size() == 0;
    const TensorShape given = for_all ? TensorShape::Scalar() : shape;
    const absl::Status status = is_level ? ReadLevelSeeds(name, tensor, given, &read.level_seeds)
                                         : ReadRandSeeds(name, tensor, given, &read.rand_seeds);
    if (!status.ok()) {
      return status;
    }
  }
  return read;
}

absl::Status CheckNoSettings(absl::string_view request, const Settings& settings) {
  if (settings.empty()) {
    return absl::OkStatus();
  }
  return UnknownSetting(settings.begin()->first, absl::StrCat("none with ", request));
}

}  // namespace procgen
