#include "procgen_client/internal/pool_messages.h"

#include <cstddef>
#include <cstdint>
#include <string>

#include "proto/engine_enums.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

void SetOptions(const procgen::EnvironmentOptions& options, v1::EnvironmentOptions* message) {
  message->set_distribution_mode(EnumOf(procgen::kDistributionModes, options.distribution_mode));
  message->set_num_levels(options.num_levels);
  message->set_start_level(options.start_level);
  message->set_rand_seed(options.rand_seed);
  message->set_use_sequential_levels(options.use_sequential_levels);
  message->set_center_agent(options.center_agent);
  message->set_use_backgrounds(options.use_backgrounds);
  message->set_use_generated_assets(options.use_generated_assets);
  message->set_use_monochrome_assets(options.use_monochrome_assets);
  message->set_restrict_themes(options.restrict_themes);
  message->set_paint_vel_info(options.paint_vel_info);
  message->set_debug_mode(options.debug_mode);
  message->set_variant(procgen::VariantText(options.variant, options.variant_value));
}

void SetFormat(const procgen::ObservationFormat& format, v1::ObservationFormat* message) {
  message->set_color(EnumOf(procgen::kColors, format.frame.color));
  message->set_layout(EnumOf(procgen::kLayouts, format.frame.layout));
  message->set_size_px(format.frame.size_px);
  message->set_frame_stack(format.frame_stack);
}

void AddReset(const procgen::Reset& reset, v1::Reset* message) {
  message->set_environment(reset.environment);
  if (reset.level_seed.has_value()) {
    message->set_level_seed(*reset.level_seed);
  }
  if (reset.rand_seed.has_value()) {
    message->set_rand_seed(*reset.rand_seed);
  }
}

void SetStep(const procgen::StepInput& input, absl::Span<const Annotation> annotations,
             v1::Step* step) {
  step->mutable_actions()->Add(input.actions.begin(), input.actions.end());
  step->set_repeat_count(input.repeat);
  for (const procgen::NextLevel& next : input.next_levels) {
    v1::NextLevel* message = step->add_next_levels();
    message->set_environment(next.environment);
    message->set_level_seed(next.level_seed);
  }
  for (const procgen::Reset& reset : input.resets) {
    AddReset(reset, step->add_resets());
  }
  for (const Annotation& annotation : annotations) {
    v1::Annotation* message = step->add_annotations();
    message->set_name(annotation.name.data(), annotation.name.size());
    message->mutable_values()->Add(annotation.values.begin(), annotation.values.end());
  }
}

// Sets the slice and the observations of any request.
template <typename Message>
void SetRows(const procgen::StepInput& input, bool with_observations, Message* message) {
  message->mutable_slice()->set_first_env(input.first);
  message->mutable_slice()->set_env_count(input.count);
  message->set_observation(with_observations ? v1::OBSERVATION_FRAME : v1::OBSERVATION_NONE);
}

}  // namespace

v1::PoolSpec SpecOf(const procgen::PoolOptions& options, v1::Encoding encoding) {
  v1::PoolSpec spec;
  for (const std::string& game : options.games) {
    spec.add_games(game);
  }
  spec.set_env_count(options.env_count);
  SetOptions(options.environment, spec.mutable_options());
  spec.set_first_env(options.first_env);
  spec.set_total_env_count(options.total_env_count);
  spec.set_autoreset_mode(EnumOf(procgen::kAutoresetModes, options.autoreset_mode));
  SetFormat(options.observation_format, spec.mutable_observation_format());
  spec.set_encoding(encoding);
  if (options.level_sampler != nullptr) {
    *spec.mutable_level_sampler() = MessageOf(*options.level_sampler);
  }
  return spec;
}

v1::LevelSampler MessageOf(const procgen::LevelSampler& level_sampler) {
  v1::LevelSampler message;
  message.mutable_level_seeds()->Add(level_sampler.level_seeds().begin(),
                                     level_sampler.level_seeds().end());
  message.mutable_weights()->Add(level_sampler.weights().begin(), level_sampler.weights().end());
  message.set_rand_seed(level_sampler.rand_seed());
  return message;
}

v1::RunPoolRequest RequestOf(const procgen::StepInput& input,
                             absl::Span<const Annotation> annotations, WantedObservations wanted) {
  v1::RunPoolRequest request;
  if (input.steps) {
    v1::Step* step = request.mutable_step();
    SetStep(input, annotations, step);
    step->set_with_final_observations(wanted.final);
    SetRows(input, wanted.current, step);
  } else if (!input.resets.empty()) {
    v1::ResetSlice* reset_slice = request.mutable_reset();
    for (const procgen::Reset& reset : input.resets) {
      AddReset(reset, reset_slice->add_resets());
    }
    SetRows(input, wanted.current, reset_slice);
  } else {
    SetRows(input, wanted.current, request.mutable_observe());
  }
  return request;
}

}  // namespace procgen_client
