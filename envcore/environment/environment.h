#ifndef ENVCORE_ENVIRONMENT_ENVIRONMENT_H_
#define ENVCORE_ENVIRONMENT_ENVIRONMENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/environment/environment_options.h"
#include "envcore/environment/fingerprint.h"
#include "envcore/environment/level_sampler.h"
#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "envcore/games/game_objects.h"
#include "envcore/random/random_stream.h"
#include "envcore/scene/scene.h"
#include "envcore/state/state_archive.h"
#include "envcore/status/status.h"

namespace procgen {

// What happens when an episode ends, by Gymnasium's names.
enum class AutoresetMode : int32_t {
  // The step returns the first observation of the next episode, as upstream does.
  kSameStep = 0,
  // The step returns the last observation. The next step ignores its action and begins the next
  // episode.
  kNextStep = 1,
  // The step returns the last observation. Stepping again without a reset is an error.
  kDisabled = 2,
};

// The result of a step, and of creation and reset, without the observation.
struct StepResult {
  float reward = 0;                  // of this step; if an episode ended, its last reward
  bool first = true;                 // a new episode has begun
  bool terminated = false;           // the game, or kEndEpisodeAction, ended the episode
  bool truncated = false;            // the step limit ended the episode
  int32_t level_seed = 0;            // of the level now shown
  int32_t prev_level_seed = 0;       // of the level that was stepped
  bool prev_level_complete = false;  // whether that level was completed
  float episode_return = 0;          // of the episode that ended, else of the running one so far
  int32_t episode_length = 0;        // number of steps of that episode
  uint64_t fingerprint = 0;          // of that episode
};

// What a snapshot contains about the episode it was saved in.
struct SavedEpisode {
  EnvironmentOptions options;   // without rand_seed; exploration mode resolved
  int32_t level_seed = 0;       // of the current level
  int32_t episode_length = 0;   // steps
  bool awaits_episode = false;  // the episode has ended and the next has not begun
  int64_t level_draws = 0;      // number of draws from the level-seed stream since it was seeded
};

// Reads these fields without making an environment. Errors: as Environment::Restore, for the fields
// that it reads.
StatusOr<SavedEpisode> ReadSavedMoment(absl::string_view snapshot,
                                       StateArchive::Floats floats = StateArchive::Floats::kExact);

// One environment: a sequence of levels, with steps and episode ends.
// Threads: compatible (one thread at a time).
class Environment {
 public:
  // Makes an environment at the first step of its first level. `options`: as returned by
  // ResolveOptions for the game. `level_stream_seed`: seeds the level-seed stream. `level_sampler`:
  // see SetLevelSampler. `spec` must outlive the environment.
  Environment(const GameSpec& spec, const EnvironmentOptions& options, uint32_t level_stream_seed,
              AutoresetMode autoreset_mode,
              std::shared_ptr<const LevelSampler> level_sampler = nullptr);

  // Returns a snapshot of all state that influences the future, and of the last result. The
  // environment plays on unchanged, with one exception: steps after restoring a hand-made snapshot
  // can leave the ranges of the snapshot format. Such values are clamped, in the environment and in
  // the snapshot, so that both continue identically.
  // Errors: INTERNAL: the state does not fit into a snapshot, which is a bug.
  StatusOr<std::string> SaveState();

  // Makes an environment from `snapshot`, options included; only `autoreset_mode` is not in the
  // snapshot. One that was saved between two episodes begins the next with its next step or, with
  // kDisabled, with a reset. The bytes may be untrusted.
  // Errors: DATA_LOSS: not a complete snapshot of this version. FAILED_PRECONDITION: a snapshot of
  // another game. INVALID_ARGUMENT: a value out of range (the message names the field).
  static StatusOr<std::unique_ptr<Environment>> Restore(const GameSpec& spec,
                                                        absl::string_view snapshot,
                                                        AutoresetMode autoreset_mode);
  // The same of the game that the snapshot names, with AutoresetMode::kSameStep. Errors: as
  // Restore; INVALID_ARGUMENT: there is no such game.
  static StatusOr<std::unique_ptr<Environment>> RestoreAny(
      absl::string_view snapshot, StateArchive::Floats floats = StateArchive::Floats::kExact);

  // Whether the state of this episode was changed by hand (readable_state.h). Snapshots contain it.
  bool edited() const { return edited_; }
  // Marks the state as changed by hand, until the next episode. `checksum`: of the changed state;
  // it becomes part of the episode's fingerprint. Errors: INVALID_ARGUMENT: the agent is where it
  // cannot be.
  Status MarkEdited(uint32_t checksum);

  // Sets the next level. It is used instead of a draw, so the level-seed stream does not advance.
  void SetNextLevel(int32_t level_seed) { next_level_ = level_seed; }

  // Sets the sampler that chooses levels, from the next choice on. Null: the options choose.
  // SetNextLevel takes precedence. A snapshot contains the position of the level-seed stream but
  // not the sampler: with the same sampler a restored environment continues exactly.
  void SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler) {
    level_sampler_ = std::move(level_sampler);
  }
  // Reseeds the level-seed stream.
  void SeedLevels(int64_t rand_seed) { level_stream_.Seed(rand_seed); }

  // Begins a new episode immediately; the result's reward is 0. `level_seed`: the level to play.
  // `rand_seed`: reseeds the level-seed stream before the level is chosen.
  void Reset(std::optional<int32_t> level_seed, std::optional<int64_t> rand_seed);

  // Takes `action`, in [kEndEpisodeAction, kActionCount), up to `repeat` times and sums the
  // rewards. Stops when a level ends. When an episode ends, `before_new_level` is called while the
  // last frame can still be drawn. If the episode had ended before, the step begins the next one
  // and ignores the action. REQUIRES: !awaits_reset().
  void Step(int32_t action, int32_t repeat, absl::FunctionRef<void()> before_new_level);

  // Whether the episode has ended and the environment needs a Reset (kDisabled only).
  bool awaits_reset() const { return ended_ && autoreset_mode_ == AutoresetMode::kDisabled; }
  const GameSpec& spec() const { return spec_; }

  const StepResult& result() const { return result_; }
  const Game& game() const { return *game_; }
  // As procgen::ReadObjects, of the current level.
  int32_t ReadObjects(absl::Span<ObjectRow> rows) const;
  // Fills `scene` with what is visible now. Valid until the environment changes.
  void FillScene(Scene* scene) const { game_->FillScene(scene); }
  // As FillScene, with the whole level.
  void FillLevelScene(Scene* scene) { game_->FillLevelScene(scene); }

 private:
  // Makes an environment without a level.
  Environment(const GameSpec& spec, const EnvironmentOptions& options,
              AutoresetMode autoreset_mode);

  // Restores what follows the game, options and level of a snapshot.
  static StatusOr<std::unique_ptr<Environment>> RestoreRest(const GameSpec& spec,
                                                            const EnvironmentOptions& options,
                                                            int32_t level_seed,
                                                            AutoresetMode autoreset_mode,
                                                            StateArchive& archive);
  // Visits all state except the options and the level seed.
  void VisitState(StateArchive& archive);
  void StepOnce(int32_t action, absl::FunctionRef<void()> before_new_level);
  // Chooses and begins the next level. In order of precedence: SetNextLevel, the sampler, the next
  // in a sequence after a completed level, a draw from the range of the options.
  void BeginLevel(bool follows_completed);
  // Begins the first level of a new episode.
  void BeginEpisode();

  const GameSpec& spec_;
  const EnvironmentOptions options_;
  const int32_t step_limit_;
  const AutoresetMode autoreset_mode_;
  int32_t level_seed_low_;  // level seeds are drawn from [low, high)
  int32_t level_seed_high_;
  std::unique_ptr<Game> game_;
  RandomStream level_stream_;
  std::shared_ptr<const LevelSampler> level_sampler_;
  std::optional<int32_t> next_level_;
  StepResult result_;
  float episode_return_ = 0;  // of the running episode
  int32_t episode_length_ = 0;
  Fingerprint fingerprint_;  // of the running episode
  bool ended_ = false;       // the episode has ended and the next has not begun
  bool is_restored_ = false;
  bool edited_ = false;  // the state of this episode was changed by hand
};

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_ENVIRONMENT_H_
