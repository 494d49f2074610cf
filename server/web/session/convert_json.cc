#include "server/web/session/convert_json.h"

#include <cstdint>
#include <string>
#include <utility>

#include "absl/strings/numbers.h"
#include "google/protobuf/duration.pb.h"
#include "server/web/play/level_choice.h"
#include "server/web/play/page_pool.h"
#include "server/web/play/recording.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

Json ModeJson(const v1::GameMode& mode) {
  Json json = {{"name", ModeName(mode.distribution_mode())},
               {"time_limit_steps", mode.time_limit_steps()}};
  if (mode.has_return_range()) {
    json["return_range"] = {{"min", mode.return_range().min()}, {"max", mode.return_range().max()}};
  }
  if (mode.has_level_seed()) {
    json["level_seed"] = mode.level_seed();
  }
  return json;
}

Json GameJson(const v1::Game& game) {
  Json modes = Json::array();
  for (const v1::GameMode& mode : game.modes()) {
    modes.push_back(ModeJson(mode));
  }
  Json special_actions = Json::array();
  for (const v1::SpecialAction& special : game.special_actions()) {
    special_actions.push_back(
        {{"action", special.action()}, {"description", special.description()}});
  }
  return {{"name", game.name()},
          {"description", game.description()},
          {"modes", std::move(modes)},
          {"special_actions", std::move(special_actions)}};
}

Json OptionJson(const v1::Option& option) {
  Json json = {{"name", option.name()}, {"description", option.description()}};
  if (option.type() == v1::OPTION_TYPE_BOOLEAN) {
    json["type"] = "boolean";
    json["default"] = option.default_value() == "true";
    return json;
  }
  json["type"] = "integer";
  json["min"] = option.min();
  json["max"] = option.max();
  int64_t number = 0;
  if (absl::SimpleAtoi(option.default_value(), &number)) {
    json["default"] = number;
  }
  return json;
}

// The options that a page can set, in the form of the requests' `options`.
Json OptionsJson(const v1::EnvironmentOptions& options) {
  return {{"use_sequential_levels", options.use_sequential_levels()},
          {"num_levels", options.num_levels()},
          {"start_level", options.start_level()},
          {"center_agent", options.center_agent()},
          {"use_backgrounds", options.use_backgrounds()},
          {"use_generated_assets", options.use_generated_assets()},
          {"use_monochrome_assets", options.use_monochrome_assets()},
          {"restrict_themes", options.restrict_themes()},
          {"paint_vel_info", options.paint_vel_info()},
          {"debug_mode", options.debug_mode()}};
}

Json MillisecondsJson(bool is_there, const google::protobuf::Duration& duration) {
  constexpr double kMillisecondsPerSecond = 1e3;
  constexpr double kMillisecondsPerNanosecond = 1e-6;
  if (!is_there) {
    return nullptr;
  }
  return static_cast<double>(duration.seconds()) * kMillisecondsPerSecond +
         static_cast<double>(duration.nanos()) * kMillisecondsPerNanosecond;
}

}  // namespace

double SecondsOf(const google::protobuf::Timestamp& time) {
  constexpr double kSecondsPerNanosecond = 1e-9;
  return static_cast<double>(time.seconds()) +
         static_cast<double>(time.nanos()) * kSecondsPerNanosecond;
}

Json MeanReturnJson(const v1::Pool& pool) {
  return pool.episode_count() == 0 ? Json() : Json(pool.mean_episode_return());
}

Json MeanLengthJson(const v1::Pool& pool) {
  return pool.episode_count() == 0 ? Json() : Json(pool.mean_episode_length());
}

Json RequestP50MsJson(const v1::Pool& pool) {
  return MillisecondsJson(pool.has_request_duration_p50(), pool.request_duration_p50());
}

Json RequestP99MsJson(const v1::Pool& pool) {
  return MillisecondsJson(pool.has_request_duration_p99(), pool.request_duration_p99());
}

Json CatalogJson(const v1::Catalog& catalog) {
  Json games = Json::array();
  for (const v1::Game& game : catalog.games()) {
    games.push_back(GameJson(game));
  }
  Json options = Json::array();
  for (const v1::Option& option : catalog.options()) {
    if (!IsChosenOtherwise(option.name())) {
      options.push_back(OptionJson(option));
    }
  }
  Json actions = Json::array();
  for (const v1::Action& action : catalog.actions()) {
    Json keys = Json::array();
    for (const std::string& key : action.keys()) {
      keys.push_back(key);
    }
    actions.push_back(
        {{"number", action.number()}, {"name", action.name()}, {"keys", std::move(keys)}});
  }
  return {{"games", std::move(games)},
          {"options", std::move(options)},
          {"actions", std::move(actions)}};
}

Json PoolJson(const v1::Pool& pool) {
  Json games = Json::array();
  for (const std::string& game : pool.spec().games()) {
    games.push_back(game);
  }
  return {{"name", pool.name()},
          {"owner", pool.owner()},
          {"kind", KindOfPool(pool.name())},
          {"games", std::move(games)},
          {"mode", ModeName(pool.spec().options().distribution_mode())},
          {"options", OptionsJson(pool.spec().options())},
          {"env_count", pool.spec().env_count()},
          {"first_env", pool.spec().first_env()},
          {"step_count", pool.step_count()},
          {"episode_count", pool.episode_count()},
          {"mean_return", MeanReturnJson(pool)},
          {"mean_length", MeanLengthJson(pool)},
          {"request_p50_ms", RequestP50MsJson(pool)},
          {"request_p99_ms", RequestP99MsJson(pool)},
          {"create_time_s", SecondsOf(pool.create_time())}};
}

Json EpisodesJson(const v1::Pool& pool, const EpisodeList& list) {
  Json rows = Json::array();
  int64_t number = list.count - static_cast<int64_t>(list.episodes.size());
  for (const EndedEpisode& episode : list.episodes) {
    rows.push_back({++number, episode.end_time_s, episode.environment, episode.level_seed,
                    episode.total_reward, episode.length, episode.level_complete,
                    episode.is_truncated, FingerprintJson(episode.fingerprint)});
  }
  return {{"pool", pool.name()},
          {"create_time_s", SecondsOf(pool.create_time())},
          {"episode_count", list.count},
          {"recorded_count", list.recorded_count},
          {"columns",
           {"number", "end_time_s", "environment", "level_seed", "total_reward", "length",
            "level_complete", "truncated", "fingerprint"}},
          {"rows", std::move(rows)}};
}

Json NodesJson(const v1::ListNodesResponse& nodes) {
  Json list = Json::array();
  for (const v1::Node& node : nodes.nodes()) {
    list.push_back({{"name", node.name()},
                    {"address", node.address()},
                    {"version", node.server_version()},
                    {"environment_capacity", node.environment_capacity()},
                    {"env_count", node.env_count()},
                    {"pool_count", node.pool_count()},
                    {"worker_count", node.worker_count()},
                    {"steps_per_second", node.steps_per_second()},
                    {"healthy", node.healthy()},
                    {"draining", node.draining()}});
  }
  return list;
}

Json LoadJson(const v1::Load& load, const std::vector<PoolReport>& pools, double steps_per_second) {
  int64_t pool_count = 0;
  int64_t env_count = 0;
  for (const PoolReport& report : pools) {
    const v1::Pool& pool = report.pool;
    if (KindOfPool(pool.name()) == "pool") {
      ++pool_count;
      env_count += pool.spec().env_count();
    }
  }
  return {{"pool_count", pool_count},
          {"env_count", env_count},
          {"worker_count", load.worker_count()},
          {"step_count", load.step_count()},
          {"steps_per_second", steps_per_second},
          {"draining", load.draining()}};
}

}  // namespace procgen::web
