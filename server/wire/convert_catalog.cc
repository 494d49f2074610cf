#include "server/wire/convert_catalog.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "absl/strings/str_split.h"
#include "envcore/pool/pool.h"
#include "proto/engine_enums.h"
#include "server/wire/convert_pool.h"

namespace procgen {
namespace {

void FillMode(const GameSpec& spec, DistributionMode mode, v1::Game* game) {
  v1::GameMode* message = game->add_modes();
  message->set_distribution_mode(DistributionModeMessageOf(mode));
  message->set_time_limit_steps(spec.StepLimit(mode));
  if (mode == DistributionMode::kEasy || mode == DistributionMode::kHard) {
    const ReturnRange range =
        mode == DistributionMode::kEasy ? spec.easy_returns : spec.hard_returns;
    message->mutable_return_range()->set_min(range.min);
    message->mutable_return_range()->set_max(range.max);
  }
  if (mode == DistributionMode::kExploration) {
    message->set_level_seed(*spec.exploration_level);
  }
}

void FillGame(const GameSpec& spec, v1::Game* game) {
  game->set_name(std::string(spec.name));
  game->set_description(std::string(spec.description));
  for (const DistributionMode mode : spec.modes) {
    FillMode(spec, mode, game);
  }
  if (spec.exploration_level.has_value()) {
    FillMode(spec, DistributionMode::kExploration, game);
  }
  game->set_action_count(kActionCount);
  for (const SpecialAction& special : spec.special_actions) {
    v1::SpecialAction* message = game->add_special_actions();
    message->set_action(special.action);
    message->set_description(std::string(special.description));
  }
  for (const VariantSpec& variant : VariantCatalog()) {
    if (variant.game == spec.name) {
      v1::Variant* message = game->add_variants();
      message->set_name(VariantText(variant));
      message->set_description(std::string(variant.description));
    }
  }
}

// An option of EnvironmentOptions in the catalog. `min`, `max`: of integer options.
struct OptionInfo {
  const char* name;
  const char* description;
  v1::OptionType type;
  const char* default_value;
  int64_t min = 0;
  int64_t max = 0;
};

constexpr OptionInfo kOptions[] = {
    {"distribution_mode", "Distribution of levels.", v1::OPTION_TYPE_NAME, "hard"},
    {"num_levels", "Number of different levels; 0: unlimited.", v1::OPTION_TYPE_INTEGER, "0", 0,
     INT32_MAX},
    {"start_level", "First level seed; ignored if num_levels is 0.", v1::OPTION_TYPE_INTEGER, "0",
     0, INT32_MAX},
    {"rand_seed", "Seed of the choice of levels, modulo 2^32.", v1::OPTION_TYPE_INTEGER, "random",
     INT64_MIN, INT64_MAX},
    {"use_sequential_levels", "After a completed level the episode continues in the next one.",
     v1::OPTION_TYPE_BOOLEAN, "false"},
    {"center_agent", "The camera follows the agent; some games override it.",
     v1::OPTION_TYPE_BOOLEAN, "true"},
    {"use_backgrounds", "Background images; otherwise black.", v1::OPTION_TYPE_BOOLEAN, "true"},
    {"use_generated_assets", "Sprites generated from random numbers; changes sizes and levels.",
     v1::OPTION_TYPE_BOOLEAN, "false"},
    {"use_monochrome_assets", "Flat rectangles in place of art.", v1::OPTION_TYPE_BOOLEAN, "false"},
    {"restrict_themes", "One theme for each kind of object.", v1::OPTION_TYPE_BOOLEAN, "false"},
    {"paint_vel_info", "Two grey squares show the agent's velocity.", v1::OPTION_TYPE_BOOLEAN,
     "false"},
    {"debug_mode", "Bit mask that only coinrun reads.", v1::OPTION_TYPE_INTEGER, "0", INT32_MIN,
     INT32_MAX},
    {"variant", "One change of each level of a game.", v1::OPTION_TYPE_NAME, ""},
};

void FillOptions(v1::Catalog* catalog) {
  for (const OptionInfo& facts : kOptions) {
    v1::Option* option = catalog->add_options();
    option->set_name(facts.name);
    option->set_description(facts.description);
    option->set_type(facts.type);
    option->set_default_value(facts.default_value);
    option->set_min(facts.min);
    option->set_max(facts.max);
  }
  for (const DistributionMode mode :
       {DistributionMode::kEasy, DistributionMode::kHard, DistributionMode::kExtreme,
        DistributionMode::kMemory, DistributionMode::kExploration}) {
    catalog->mutable_options(0)->add_names(std::string(DistributionModeName(mode)));
  }
  v1::Option* const variant = catalog->mutable_options(catalog->options_size() - 1);
  for (const VariantSpec& spec : VariantCatalog()) {
    const std::string text = VariantText(spec);
    if (std::find(variant->names().begin(), variant->names().end(), text) ==
        variant->names().end()) {
      variant->add_names(text);
    }
  }
}

void FillActions(v1::Catalog* catalog) {
  for (int32_t number = 0; number < kActionCount; ++number) {
    v1::Action* action = catalog->add_actions();
    const std::string name(ActionName(number));
    action->set_number(number);
    action->set_name(name);
    if (number != kNoAction) {
      for (const absl::string_view key : absl::StrSplit(name, '+')) {
        action->add_keys(std::string(key));
      }
    }
  }
}

void FillLimits(const Limits& limits, v1::Limits* message) {
#define PROCGEN_SET(name, value, least, most, what) \
  message->set_##name(static_cast<decltype(message->name())>(limits.name));
  PROCGEN_LIMITS(PROCGEN_SET)
#undef PROCGEN_SET
  message->set_observation_size_px_min(kObservationSizePxMin);
  message->set_observation_size_px_max(kObservationSizePxMax);
  message->set_frame_stack_max(kFrameStackMax);
}

void FillLatencyHistogram(const HistogramCounts& seconds, v1::LatencyHistogram* message) {
  message->mutable_bounds_seconds()->Assign(seconds.bounds.begin(), seconds.bounds.end());
  message->mutable_counts()->Assign(seconds.counts.begin(), seconds.counts.end());
  message->set_sum_seconds(seconds.sum);
}

}  // namespace

v1::Catalog CatalogMessageOf(const ServerInfo& server, const Limits& limits) {
  v1::Catalog catalog;
  catalog.set_server_version(std::string(server.version));
  for (const GameSpec& spec : GameCatalog()) {
    FillGame(spec, catalog.add_games());
  }
  FillOptions(&catalog);
  FillActions(&catalog);
  catalog.add_encodings(v1::ENCODING_RAW);
  catalog.add_encodings(v1::ENCODING_DELTA_ZSTD);
  for (const auto& [color, value] : kColors) {
    catalog.add_colors(color);
  }
  for (const auto& [layout, value] : kLayouts) {
    catalog.add_layouts(layout);
  }
  for (const auto& [mode, value] : kAutoresetModes) {
    catalog.add_autoreset_modes(mode);
  }
  FillLimits(limits, catalog.mutable_limits());
  // Clients must not see the path of the directory.
  catalog.set_art(server.has_own_art ? "folder" : "built-in");
  return catalog;
}

v1::Load LoadMessageOf(const Load& load, const StreamTotals& streams) {
  v1::Load message;
  message.set_pool_count(load.pool_count);
  message.set_env_count(load.env_count);
  message.set_worker_count(load.worker_count);
  message.set_step_count(load.step_count);
  message.set_draining(load.draining);
  message.set_stream_received_bytes(streams.received_bytes);
  message.set_stream_sent_bytes(streams.sent_bytes);
  FillLatencyHistogram(streams.queue_seconds, message.mutable_queue_wait());
  FillLatencyHistogram(streams.run_seconds, message.mutable_execution_time());
  return message;
}

}  // namespace procgen
