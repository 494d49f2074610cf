#include "clients/c/conversion.h"

#include <sys/random.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "envcore/environment/environment_options.h"

namespace procgen_client {
namespace {

constexpr int32_t kGameCountMax = 64;

procgen::Status CheckEnum(absl::string_view name, int32_t value,
                          std::initializer_list<int32_t> allowed) {
  if (std::find(allowed.begin(), allowed.end(), value) == allowed.end()) {
    return procgen::InvalidArgumentError(
        absl::StrCat(name, " is ", value, ", must be one of ", absl::StrJoin(allowed, ", ")));
  }
  return procgen::OkStatus();
}

procgen::StatusOr<std::vector<std::string>> GamesOf(const ProcgenPoolOptions& options) {
  if (options.game_count < 1 || options.game_count > kGameCountMax) {
    return procgen::InvalidArgumentError(absl::StrCat("game_count is ", options.game_count,
                                                      ", must be in [1, ", kGameCountMax, "]"));
  }
  std::vector<std::string> games;
  for (int32_t i = 0; i < options.game_count; ++i) {
    if (options.games == nullptr || options.games[i] == nullptr) {
      return procgen::InvalidArgumentError(absl::StrCat("games[", i, "] is null"));
    }
    games.emplace_back(options.games[i]);
  }
  return games;
}

// Not std::random_device: it calls functions of a newer C library than anything else here.
int64_t DrawRandSeed() {
  uint64_t number = 0;
  if (getrandom(&number, sizeof(number), 0) != static_cast<ssize_t>(sizeof(number))) {
    throw std::runtime_error("getrandom failed: the system has no random numbers");
  }
  return static_cast<int64_t>(number % INT32_MAX);
}

procgen::EnvironmentOptions EnvironmentOptionsOf(const ProcgenPoolOptions& options) {
  procgen::EnvironmentOptions result;
  result.distribution_mode = static_cast<procgen::DistributionMode>(options.distribution_mode);
  result.center_agent = options.center_agent != 0;
  result.use_backgrounds = options.use_backgrounds != 0;
  result.use_generated_assets = options.use_generated_assets != 0;
  result.use_monochrome_assets = options.use_monochrome_assets != 0;
  result.restrict_themes = options.restrict_themes != 0;
  result.paint_vel_info = options.paint_vel_info != 0;
  result.debug_mode = options.debug_mode;
  result.num_levels = options.num_levels;
  result.start_level = options.start_level;
  result.rand_seed = options.has_rand_seed != 0 ? options.rand_seed : DrawRandSeed();
  result.use_sequential_levels = options.use_sequential_levels != 0;
  return result;
}

}  // namespace

ProcgenPoolOptions DefaultPoolOptions() {
  ProcgenPoolOptions options = {};
  options.struct_size = sizeof(options);
  options.distribution_mode = PROCGEN_HARD;
  options.center_agent = 1;
  options.use_backgrounds = 1;
  options.autoreset_mode = PROCGEN_SAME_STEP;
  options.screen_size = procgen::kObservationSizePx;
  options.frame_stack = 1;
  options.layout = PROCGEN_HWC;
  options.num_threads = -1;
  return options;
}

void SetDefaults(ProcgenPoolOptions* options, size_t struct_size) {
  const ProcgenPoolOptions defaults = DefaultPoolOptions();
  std::memcpy(options, &defaults, std::min(struct_size, sizeof(defaults)));
  options->struct_size = struct_size;
}

procgen::StatusOr<procgen::PoolOptions> PoolOptionsOf(const ProcgenPoolOptions& options) {
  for (const procgen::Status& status :
       {CheckEnum(
            "distribution_mode", options.distribution_mode,
            {PROCGEN_EASY, PROCGEN_HARD, PROCGEN_EXTREME, PROCGEN_MEMORY, PROCGEN_EXPLORATION}),
        CheckEnum("autoreset_mode", options.autoreset_mode,
                  {PROCGEN_SAME_STEP, PROCGEN_NEXT_STEP, PROCGEN_DISABLED}),
        CheckEnum("layout", options.layout, {PROCGEN_HWC, PROCGEN_CHW})}) {
    if (!status.ok()) {
      return status;
    }
  }
  auto games = GamesOf(options);
  if (!games.ok()) {
    return games.status();
  }
  procgen::PoolOptions result;
  result.games = *std::move(games);
  result.env_count = options.env_count;
  result.first_env = options.first_env;
  result.total_env_count = options.total_env_count;
  result.environment = EnvironmentOptionsOf(options);
  const procgen::Status variant = procgen::RequireVariant(
      options.variant == nullptr ? "" : options.variant, &result.environment);
  if (!variant.ok()) {
    return variant;
  }
  result.autoreset_mode = static_cast<procgen::AutoresetMode>(options.autoreset_mode);
  result.observation_format.frame = {
      .size_px = options.screen_size,
      .color = options.grayscale_obs != 0 ? procgen::Color::kGrayscale : procgen::Color::kRgb,
      .layout = static_cast<procgen::Layout>(options.layout)};
  result.observation_format.frame_stack = options.frame_stack;
  if (options.level_sampler != nullptr) {
    auto level_sampler = LevelSamplerOf(*options.level_sampler);
    if (!level_sampler.ok()) {
      return level_sampler.status();
    }
    result.level_sampler = *std::move(level_sampler);
  }
  return result;
}

procgen::StatusOr<std::shared_ptr<const procgen::LevelSampler>> LevelSamplerOf(
    const ProcgenLevelSampler& given) {
  const ProcgenLevelSampler sampler = Complete(given);
  if (sampler.level_seeds == nullptr || sampler.seed_count < 0 ||
      sampler.seed_count > procgen::LevelSampler::kLevelSeedsMax) {
    return procgen::InvalidArgumentError(absl::StrCat("level_sampler has ", sampler.seed_count,
                                                      " level seeds, must have 1 to ",
                                                      procgen::LevelSampler::kLevelSeedsMax));
  }
  const auto seeds = SpanOf(sampler.level_seeds, sampler.seed_count);
  const auto weights = SpanOf(sampler.weights, sampler.seed_count);
  return procgen::LevelSampler::Create({seeds.begin(), seeds.end()},
                                       {weights.begin(), weights.end()}, sampler.rand_seed);
}

std::vector<procgen::NextLevel> NextLevelsOf(const ProcgenNextLevel* next_levels, int32_t count) {
  std::vector<procgen::NextLevel> result;
  for (const ProcgenNextLevel& next : SpanOf(next_levels, count)) {
    result.push_back({.environment = next.environment, .level_seed = next.level_seed});
  }
  return result;
}

std::vector<procgen::Reset> ResetsOf(const ProcgenReset* resets, int32_t count) {
  std::vector<procgen::Reset> result;
  for (const ProcgenReset& reset : SpanOf(resets, count)) {
    procgen::Reset& converted = result.emplace_back();
    converted.environment = reset.environment;
    if (reset.has_level_seed != 0) {
      converted.level_seed = reset.level_seed;
    }
    if (reset.has_rand_seed != 0) {
      converted.rand_seed = reset.rand_seed;
    }
  }
  return result;
}

procgen::StepInput StepInputOf(const ProcgenStep& step,
                               absl::Span<const procgen::NextLevel> next_levels,
                               absl::Span<const procgen::Reset> resets) {
  return {.first = step.first_env,
          .count = step.env_count,
          .actions = SpanOf(step.actions, std::max(step.env_count, 0)),
          .repeat = step.repeat_count == 0 ? 1 : step.repeat_count,
          .next_levels = next_levels,
          .resets = resets};
}

procgen::StatusOr<std::vector<Annotation>> AnnotationsOf(const ProcgenStep& step) {
  std::vector<Annotation> result;
  for (int32_t i = 0; i < step.annotation_count; ++i) {
    const ProcgenAnnotation& annotation = step.annotations[i];
    if (annotation.name == nullptr || annotation.values == nullptr || annotation.value_count < 1) {
      return procgen::InvalidArgumentError(absl::StrCat(
          "annotations[", i, "] has ",
          annotation.name == nullptr ? "no name" : absl::StrCat("the name ", annotation.name), ", ",
          annotation.values == nullptr ? "no values" : "values", " and value_count ",
          annotation.value_count, ", must have a name, values and a value_count of at least 1"));
    }
    const auto size = int64_t{std::max(step.env_count, 0)} * annotation.value_count;
    result.push_back({.name = annotation.name, .values = SpanOf(annotation.values, size)});
  }
  return result;
}

procgen::Batch BatchOf(const ProcgenBatch& given, int32_t env_count, size_t observation_bytes) {
  const ProcgenBatch batch = Complete(given);
  const auto rows = static_cast<size_t>(std::max(env_count, 0));
  const auto span = [](auto* array, size_t size) {
    return absl::MakeSpan(array, array == nullptr ? 0 : size);
  };
  procgen::Batch result;
  result.observations = span(batch.observations, rows * observation_bytes);
#define PROCGEN_SPAN(type, name, member) result.name = span(batch.name, rows);
  PROCGEN_BATCH_NUMBERS(PROCGEN_SPAN)
#undef PROCGEN_SPAN
  result.final_observations = span(batch.final_observations, rows * observation_bytes);
  return result;
}

void Fill(const procgen::PoolOptions& options, int32_t thread_count, ProcgenPoolInfo* info) {
  ProcgenPoolInfo full = {};
  full.struct_size = info->struct_size;
  full.env_count = options.env_count;
  full.num_threads = thread_count;
  full.rand_seed = options.environment.rand_seed;
  const std::vector<int32_t> shape = options.observation_format.Shape();
  full.observation_rank = static_cast<int32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), full.observation_shape);
  full.observation_bytes = static_cast<int64_t>(options.observation_format.bytes());
  std::memcpy(info, &full, std::min(info->struct_size, sizeof(full)));
}

}  // namespace procgen_client
