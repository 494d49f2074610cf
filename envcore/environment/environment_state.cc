#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "envcore/environment/environment.h"
#include "envcore/state/state_archive.h"
#include "envcore/status/status.h"

namespace procgen {
namespace {

constexpr size_t kGameNameBytesMax = 64;
constexpr int32_t kEpisodeLengthMax = 1 << 30;
constexpr float kFloatMax = std::numeric_limits<float>::max();
constexpr int32_t kIntMin = std::numeric_limits<int32_t>::min();
constexpr int32_t kIntMax = std::numeric_limits<int32_t>::max();

// What is needed to make the environment before the rest of its state is restored.
struct Beginning {
  std::string game;
  EnvironmentOptions options;
  int32_t level_seed = 0;  // of the current level
};

// rand_seed is not saved: the level-seed stream was already seeded with it.
void VisitOptions(StateArchive& archive, EnvironmentOptions& options) {
  auto mode = static_cast<int32_t>(options.distribution_mode);
  // Exploration mode is resolved when an environment is made, so it is not in a snapshot.
  archive.Int("distribution_mode", mode, 0, static_cast<int32_t>(DistributionMode::kMemory));
  options.distribution_mode = static_cast<DistributionMode>(mode);
  archive.Int("num_levels", options.num_levels, 0, kIntMax);
  archive.Int("start_level", options.start_level, 0, kIntMax);
  archive.Bool("use_sequential_levels", options.use_sequential_levels);
  archive.Bool("center_agent", options.center_agent);
  archive.Bool("use_backgrounds", options.use_backgrounds);
  archive.Bool("use_generated_assets", options.use_generated_assets);
  archive.Bool("use_monochrome_assets", options.use_monochrome_assets);
  archive.Bool("restrict_themes", options.restrict_themes);
  archive.Bool("paint_vel_info", options.paint_vel_info);
  archive.Int("debug_mode", options.debug_mode, kIntMin, kIntMax);
  auto variant = static_cast<int32_t>(options.variant);
  archive.Int("variant", variant, 0, kVariantMax, 0);
  options.variant = static_cast<Variant>(variant);
  archive.Float("variant_value", options.variant_value, 0, kFloatMax, 0);
}

void VisitBeginning(StateArchive& archive, Beginning& beginning) {
  archive.Text("game", beginning.game, kGameNameBytesMax);
  archive.Group("options", [&] { VisitOptions(archive, beginning.options); });
  archive.Int("level_seed", beginning.level_seed, kIntMin, kIntMax);
}

void VisitResult(StateArchive& archive, StepResult& result) {
  archive.Float("reward", result.reward, -kFloatMax, kFloatMax);
  archive.Bool("first", result.first);
  archive.Bool("terminated", result.terminated);
  archive.Bool("truncated", result.truncated);
  archive.Int("prev_level_seed", result.prev_level_seed, kIntMin, kIntMax);
  archive.Bool("prev_level_complete", result.prev_level_complete);
  archive.Float("episode_return", result.episode_return, -kFloatMax, kFloatMax);
  archive.Int("episode_length", result.episode_length, 0, kEpisodeLengthMax);
  archive.Bits("fingerprint", result.fingerprint);
}

// The state of the episode and of the choice of levels.
struct Progress {
  RandomStream& level_stream;
  std::optional<int32_t>& next_level;
  bool& ended;
  float& episode_return;
  int32_t& episode_length;
};

void VisitProgress(StateArchive& archive, const Progress& progress) {
  archive.Group("level_stream", [&] { progress.level_stream.VisitState(archive); });
  bool has_next_level = progress.next_level.has_value();
  int32_t next_level = progress.next_level.value_or(0);
  archive.Bool("has_next_level", has_next_level);
  archive.Int("next_level", next_level, kIntMin, kIntMax);
  if (archive.restores() && has_next_level) {
    progress.next_level = next_level;
  }
  archive.Bool("ended", progress.ended);
  archive.Float("episode_return", progress.episode_return, -kFloatMax, kFloatMax);
  archive.Int("episode_length", progress.episode_length, 0, kEpisodeLengthMax);
}

}  // namespace

StatusOr<SavedEpisode> ReadSavedMoment(absl::string_view snapshot, StateArchive::Floats floats) {
  StatusOr<StateArchive> archive = StateArchive::Open(snapshot, floats);
  if (!archive.ok()) {
    return archive.status();
  }
  Beginning beginning;
  VisitBeginning(*archive, beginning);
  SavedEpisode moment;
  RandomStream level_stream;
  std::optional<int32_t> next_level;
  float episode_return = 0;
  VisitProgress(*archive, {level_stream, next_level, moment.awaits_episode, episode_return,
                           moment.episode_length});
  if (!archive->ok()) {
    return archive->status();
  }
  moment.options = beginning.options;
  moment.level_seed = beginning.level_seed;
  moment.level_draws = static_cast<int64_t>(level_stream.draws());
  return moment;
}

StatusOr<std::string> Environment::SaveState() {
  using OutOfRange = StateArchive::OutOfRange;
  StateArchive archive(is_restored_ ? OutOfRange::kSaturates : OutOfRange::kFails);
  Beginning beginning = {
      .game = std::string(spec_.name), .options = options_, .level_seed = result_.level_seed};
  VisitBeginning(archive, beginning);
  VisitState(archive);
  return archive.Finish();
}

StatusOr<std::unique_ptr<Environment>> Environment::Restore(const GameSpec& spec,
                                                            absl::string_view snapshot,
                                                            AutoresetMode autoreset_mode) {
  StatusOr<StateArchive> archive = StateArchive::Open(snapshot);
  if (!archive.ok()) {
    return archive.status();
  }
  Beginning beginning;
  VisitBeginning(*archive, beginning);
  if (archive->ok() && beginning.game != spec.name) {
    return FailedPreconditionError(
        absl::StrCat("game is ", beginning.game, ", the environment plays ", spec.name));
  }
  return RestoreRest(spec, beginning.options, beginning.level_seed, autoreset_mode, *archive);
}

StatusOr<std::unique_ptr<Environment>> Environment::RestoreAny(absl::string_view snapshot,
                                                               StateArchive::Floats floats) {
  StatusOr<StateArchive> archive = StateArchive::Open(snapshot, floats);
  if (!archive.ok()) {
    return archive.status();
  }
  Beginning beginning;
  VisitBeginning(*archive, beginning);
  if (!archive->ok()) {
    return archive->status();
  }
  const StatusOr<const GameSpec*> spec = RequireGame(beginning.game);
  if (!spec.ok()) {
    return InvalidArgumentError(absl::StrCat("game: ", spec.status().message()));
  }
  return RestoreRest(**spec, beginning.options, beginning.level_seed, AutoresetMode::kSameStep,
                     *archive);
}

StatusOr<std::unique_ptr<Environment>> Environment::RestoreRest(const GameSpec& spec,
                                                                const EnvironmentOptions& options,
                                                                int32_t level_seed,
                                                                AutoresetMode autoreset_mode,
                                                                StateArchive& archive) {
  if (!archive.ok()) {
    return archive.status();
  }
  const auto resolved = ResolveOptions(spec.name, options);
  if (!resolved.ok()) {
    return InvalidArgumentError(absl::StrCat("options: ", resolved.status().message()));
  }
  std::unique_ptr<Environment> environment(new Environment(spec, *resolved, autoreset_mode));
  environment->is_restored_ = true;
  // Generates the level again: what its seed determines is not in the snapshot.
  environment->result_.level_seed = level_seed;
  environment->game_->StartLevel(level_seed);
  environment->VisitState(archive);
  if (Status status = archive.Close(); !status.ok()) {
    return status;
  }
  return environment;
}

Status Environment::MarkEdited(uint32_t checksum) {
  const Entity& agent = game_->world().agent();
  if (game_->AgentIsInBlock()) {
    return InvalidArgumentError(absl::StrCat("agent is at (", agent.x, ", ", agent.y,
                                             "), must be in a cell that does not block it"));
  }
  edited_ = true;
  fingerprint_.AddEdit(checksum);
  return OkStatus();
}

void Environment::VisitState(StateArchive& archive) {
  archive.Bool("edited", edited_, false);
  VisitProgress(archive, {level_stream_, next_level_, ended_, episode_return_, episode_length_});
  uint64_t fingerprint = fingerprint_.value();
  archive.Bits("fingerprint", fingerprint);
  fingerprint_.Restore(fingerprint);
  archive.Group("result", [&] { VisitResult(archive, result_); });
  archive.Group("level", [&] { game_->VisitState(archive, step_limit_); });
}

}  // namespace procgen
