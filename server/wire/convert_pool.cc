#include "server/wire/convert_pool.h"

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "proto/engine_enums.h"
#include "server/pool/pool_supervisor.h"
#include "server/wire/convert_observation.h"
#include "server/wire/enum_value.h"

namespace procgen {
namespace {

constexpr int kGamesMax = 64;
constexpr size_t kGameLengthMax = 64;  // largest length of a game's name, in characters

absl::StatusOr<EnvironmentOptions> EnvironmentOptionsOf(const v1::EnvironmentOptions& message) {
  absl::StatusOr<DistributionMode> mode =
      ValueOf(kDistributionModes, "spec.options.distribution_mode", message.distribution_mode());
  if (!mode.ok()) {
    return mode.status();
  }
  EnvironmentOptions options;
  options.distribution_mode = *mode;
  for (const auto& [field, value] : {std::pair("num_levels", message.num_levels()),
                                     std::pair("start_level", message.start_level())}) {
    if (value < 0) {
      return absl::InvalidArgumentError(
          absl::StrCat("spec.options.", field, " is ", value, ", allowed: 0 to 2147483647"));
    }
    if (*mode == DistributionMode::kExploration && value != 0) {
      return absl::InvalidArgumentError(
          absl::StrCat("spec.options.", field, " is ", value,
                       ", allowed with DISTRIBUTION_MODE_EXPLORATION: 0, it has its own level"));
    }
  }
  options.num_levels = message.num_levels();
  options.start_level = message.start_level();
  options.rand_seed = message.has_rand_seed()
                          ? message.rand_seed()
                          : static_cast<int64_t>(std::random_device()() % INT32_MAX);
  options.use_sequential_levels = message.use_sequential_levels();
  options.center_agent = message.has_center_agent() ? message.center_agent() : true;
  options.use_backgrounds = message.has_use_backgrounds() ? message.use_backgrounds() : true;
  options.use_generated_assets = message.use_generated_assets();
  options.use_monochrome_assets = message.use_monochrome_assets();
  options.restrict_themes = message.restrict_themes();
  options.paint_vel_info = message.paint_vel_info();
  options.debug_mode = message.debug_mode();
  const Status variant = RequireVariant(message.variant(), &options);
  if (!variant.ok()) {
    return absl::Status(variant.code(), absl::StrCat("spec.options.", variant.message()));
  }
  return options;
}

// Checks the fields of a spec except options and observations.
absl::Status CheckSpec(const v1::PoolSpec& spec) {
  if (spec.games_size() < 1 || spec.games_size() > kGamesMax) {
    return absl::InvalidArgumentError(
        absl::StrCat("spec.games has ", spec.games_size(), " entries, allowed: 1 to ", kGamesMax));
  }
  for (int i = 0; i < spec.games_size(); ++i) {
    if (spec.games(i).size() > kGameLengthMax) {
      return absl::InvalidArgumentError(
          absl::StrCat("spec.games[", i, "] has ", spec.games(i).size(),
                       " characters, allowed: the name of a game, at most ", kGameLengthMax));
    }
  }
  if (spec.first_env() < 0 || spec.total_env_count() < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("spec.first_env is ", spec.first_env(), " and spec.total_env_count is ",
                     spec.total_env_count(), ", allowed: at least 0"));
  }
  const int64_t least_total =
      static_cast<int64_t>(spec.first_env()) + static_cast<int64_t>(spec.env_count());
  if (least_total > INT32_MAX ||
      (spec.total_env_count() != 0 && spec.total_env_count() < least_total)) {
    return absl::InvalidArgumentError(
        absl::StrCat("spec.total_env_count is ", spec.total_env_count(),
                     ", allowed: 0, or first_env + env_count = ", least_total, " to ", INT32_MAX));
  }
  return absl::OkStatus();
}

void FillStatistics(const PoolSession& session, v1::Pool* message) {
  message->set_step_count(session.step_count());
  const RecentEpisodes::Summary episodes = session.episodes();
  message->set_episode_count(episodes.count);
  message->set_mean_episode_return(episodes.mean_return);
  message->set_mean_episode_length(episodes.mean_length);
  const RecentEpisodes::ReturnSpread spread = session.recent_episodes().ReadReturnSpread();
  message->set_min_episode_return(spread.min);
  message->set_max_episode_return(spread.max);
  message->set_episode_return_deviation(spread.deviation);
  for (const GameReturn& game : session.ReadGameReturns()) {
    v1::GameReturn* const added = message->add_game_returns();
    added->set_game(game.game);
    if (game.mean_return.has_value()) {
      added->set_mean_episode_return(*game.mean_return);
    }
  }
  const RequestTimes::Summary times = session.request_times();
  message->set_request_count(times.count);
  *message->mutable_request_duration() = DurationMessageOf(times.sum);
  if (times.count > 0) {
    *message->mutable_request_duration_p50() = DurationMessageOf(times.p50);
    *message->mutable_request_duration_p99() = DurationMessageOf(times.p99);
  }
}

}  // namespace

v1::EnvironmentOptions EnvironmentOptionsMessageOf(const EnvironmentOptions& options) {
  v1::EnvironmentOptions message;
  message.set_distribution_mode(DistributionModeMessageOf(options.distribution_mode));
  message.set_num_levels(options.num_levels);
  message.set_start_level(options.start_level);
  message.set_rand_seed(options.rand_seed);
  message.set_use_sequential_levels(options.use_sequential_levels);
  message.set_center_agent(options.center_agent);
  message.set_use_backgrounds(options.use_backgrounds);
  message.set_use_generated_assets(options.use_generated_assets);
  message.set_use_monochrome_assets(options.use_monochrome_assets);
  message.set_restrict_themes(options.restrict_themes);
  message.set_paint_vel_info(options.paint_vel_info);
  message.set_debug_mode(options.debug_mode);
  message.set_variant(VariantText(options.variant, options.variant_value));
  return message;
}

void FillTimestamp(absl::Time time, google::protobuf::Timestamp* message) {
  const timespec spec = absl::ToTimespec(time);
  message->set_seconds(spec.tv_sec);
  message->set_nanos(static_cast<int32_t>(spec.tv_nsec));
}

google::protobuf::Duration DurationMessageOf(absl::Duration duration) {
  google::protobuf::Duration message;
  const timespec spec = absl::ToTimespec(duration);
  message.set_seconds(spec.tv_sec);
  message.set_nanos(static_cast<int32_t>(spec.tv_nsec));
  return message;
}

absl::StatusOr<PoolOptions> PoolOptionsOf(const v1::PoolSpec& spec) {
  if (absl::Status status = CheckSpec(spec); !status.ok()) {
    return status;
  }
  absl::StatusOr<EnvironmentOptions> environment = EnvironmentOptionsOf(spec.options());
  if (!environment.ok()) {
    return environment.status();
  }
  absl::StatusOr<AutoresetMode> autoreset_mode =
      ValueOf(kAutoresetModes, "spec.autoreset_mode", spec.autoreset_mode());
  if (!autoreset_mode.ok()) {
    return autoreset_mode.status();
  }
  absl::StatusOr<ObservationFormat> observation_format =
      ObservationFormatOf(spec.observation_format());
  if (!observation_format.ok()) {
    return observation_format.status();
  }
  PoolOptions options;
  options.games.assign(spec.games().begin(), spec.games().end());
  options.env_count = spec.env_count();
  options.environment = *environment;
  options.autoreset_mode = *autoreset_mode;
  options.first_env = spec.first_env();
  options.total_env_count = spec.total_env_count();
  options.observation_format = *observation_format;
  if (spec.has_level_sampler()) {
    auto sampler = LevelSamplerOf("spec.level_sampler", spec.level_sampler());
    if (!sampler.ok()) {
      return sampler.status();
    }
    options.level_sampler = *std::move(sampler);
  }
  return options;
}

absl::StatusOr<SessionOptions> SessionOptionsOf(const v1::PoolSpec& spec) {
  const absl::StatusOr<Encoding> encoding = EncodingOf("spec.encoding", spec.encoding());
  if (!encoding.ok()) {
    return encoding.status();
  }
  SessionOptions options = {.encoding = *encoding,
                            .display_name = spec.display_name(),
                            .labels = {spec.labels().begin(), spec.labels().end()}};
  if (absl::Status status = CheckSessionOptions(options); !status.ok()) {
    return status;
  }
  return options;
}

v1::PoolSpec PoolSpecMessageOf(const PoolOptions& options) {
  v1::PoolSpec spec;
  spec.mutable_games()->Assign(options.games.begin(), options.games.end());
  spec.set_env_count(options.env_count);
  *spec.mutable_options() = EnvironmentOptionsMessageOf(options.environment);
  spec.set_first_env(options.first_env);
  spec.set_total_env_count(options.total_env_count != 0 ? options.total_env_count
                                                        : options.first_env + options.env_count);
  spec.set_autoreset_mode(EnumOf(kAutoresetModes, options.autoreset_mode));
  FillObservationFormat(options.observation_format, spec.mutable_observation_format());
  return spec;
}

absl::StatusOr<std::shared_ptr<const LevelSampler>> LevelSamplerOf(
    absl::string_view field, const v1::LevelSampler& message) {
  auto sampler = LevelSampler::Create({message.level_seeds().begin(), message.level_seeds().end()},
                                      {message.weights().begin(), message.weights().end()},
                                      message.rand_seed());
  if (!sampler.ok()) {
    return absl::Status(sampler.status().code(),
                        absl::StrCat(field, ".", sampler.status().message()));
  }
  return sampler;
}

absl::StatusOr<std::shared_ptr<const LevelSampler>> HoldSampler(
    absl::string_view owner, std::shared_ptr<const LevelSampler> sampler, Quotas* quotas) {
  // The sampler keeps the weights and their cumulative sums.
  const size_t bytes = sampler->level_seeds().size() * sizeof(int32_t) +
                       sampler->weights().size() * (sizeof(float) + sizeof(double));
  return quotas->Hold(owner, static_cast<int64_t>(bytes), std::move(sampler));
}

v1::Pool PoolMessageOf(const PoolSession& session) {
  v1::Pool message;
  message.set_name(session.name());
  *message.mutable_spec() = PoolSpecMessageOf(session.options());
  const SessionOptions& options = session.session_options();
  message.mutable_spec()->set_encoding(EncodingMessageOf(options.encoding));
  message.mutable_spec()->set_display_name(options.display_name);
  message.mutable_spec()->mutable_labels()->insert(options.labels.begin(), options.labels.end());
  const std::vector<int32_t> shape = session.options().observation_format.Shape();
  message.mutable_observation_shape()->Assign(shape.begin(), shape.end());
  message.set_observation_bytes(static_cast<int32_t>(session.observation_bytes()));
  message.set_owner(session.owner());
  FillStatistics(session, &message);
  FillTimestamp(session.create_time(), message.mutable_create_time());
  message.set_paused(session.paused());
  return message;
}

v1::DistributionMode DistributionModeMessageOf(DistributionMode mode) {
  return EnumOf(kDistributionModes, mode);
}

}  // namespace procgen
