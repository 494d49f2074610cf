#ifndef ENVCORE_ENVIRONMENT_ENVIRONMENT_H_
#define ENVCORE_ENVIRONMENT_ENVIRONMENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "envcore/environment/environment_options.h"
#include "envcore/environment/fingerprint.h"
#include "envcore/environment/level_sampler.h"
#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "envcore/random/random_stream.h"
#include "envcore/scene/scene.h"
#include "envcore/state/state_archive.h"

namespace procgen {

// What follows the step that ends an episode, by Gymnasium's names.
enum class AutoresetMode : int32_t {
  kSameStep =
      0,  // the next level is there at once; its first observation is answered (as upstream)
  kNextStep = 1,  // the last observation is answered; the next step ignores its action and begins
                  // the next level
  kDisabled = 2,  // the last observation is answered; stepping again without a reset is an error
};

// What an environment tells after each step (and after its creation), besides its picture.
struct StepResult {
  float reward = 0;                  // of this step, so the old episode's last one where one ended
  bool first = true;                 // a new episode has begun
  bool terminated = false;           // the game (or kEndEpisodeAction) ended the episode
  bool truncated = false;            // the step limit ended it
  int32_t level_seed = 0;            // of the level now shown
  int32_t prev_level_seed = 0;       // of the level just stepped
  bool prev_level_complete = false;  // and whether it was completed
  float episode_return = 0;  // of the ended episode where one ended, else of the running one so far
  int32_t episode_length = 0;  // steps, likewise
  uint64_t fingerprint = 0;    // likewise
};

// What a snapshot says of the moment that it was taken at.
struct SavedMoment {
  EnvironmentOptions options;   // without what is spent or resolved when an environment is made
  int32_t level_seed = 0;       // of the level that is played
  int32_t episode_length = 0;   // steps
  bool awaits_episode = false;  // the episode has ended, and the next has not begun
  int64_t level_draws = 0;      // that the choice of levels has taken since it was seeded
};

// Reads that, without making an environment. Errors: as Environment::Restore, as far as they are
// met.
absl::StatusOr<SavedMoment> ReadSavedMoment(absl::string_view snapshot);

// The life of one environment: levels one after the other, steps, episode ends.
// Threads: compatible (one thread at a time).
class Environment {
 public:
  // `options` as ResolveOptions gave them for the game; `level_stream_seed` seeds the choice of
  // levels; `level_sampler`: as SetLevelSampler. The environment stands at the first step of its
  // first level. `spec` must outlive it.
  Environment(const GameSpec& spec, const EnvironmentOptions& options, uint32_t level_stream_seed,
              AutoresetMode autoreset_mode,
              std::shared_ptr<const LevelSampler> level_sampler = nullptr);

  // A snapshot of all that influences the future, and of what was observed last. Changes nothing of
  // what a game can be played to. Where steps from a snapshot of somebody's own making led out of
  // the ranges of a snapshot, the values become the nearest in range, here and in the snapshot, so
  // that both continue alike. Errors: INTERNAL the state is none that a snapshot can hold, which is
  // a bug.
  absl::StatusOr<std::string> SaveState();

  // The environment that `snapshot` was taken of, options and all; only what follows an episode's
  // end is said anew. One that was saved between two episodes begins the next with its next step
  // or, with kDisabled, a reset. The bytes may be anyone's. Errors: DATA_LOSS they are no whole
  // snapshot of this version; FAILED_PRECONDITION the snapshot is of another game;
  // INVALID_ARGUMENT it holds what no snapshot can (the message names the field).
  static absl::StatusOr<std::unique_ptr<Environment>> Restore(const GameSpec& spec,
                                                              absl::string_view snapshot,
                                                              AutoresetMode autoreset_mode);

  // The next new level is that of `level_seed`; no draw is taken for it.
  void SetNextLevel(int32_t level_seed) { next_level_ = level_seed; }

  // What chooses each level from the next choice on that is not told otherwise; null: the options
  // do. No part of a snapshot, which holds where the stream of choices stands: with the same
  // sampler what is restored goes on as what was saved.
  void SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler) {
    level_sampler_ = std::move(level_sampler);
  }
  // Seeds the choice of levels anew.
  void SeedLevels(int64_t rand_seed) { level_stream_.Seed(rand_seed); }

  // Begins a new episode at once, with reward 0. `rand_seed` seeds the choice of levels anew before
  // the level is chosen.
  void Reset(std::optional<int32_t> level_seed, std::optional<int64_t> rand_seed);

  // Takes `action`, in [kEndEpisodeAction, kActionCount), up to `repeat` times and sums the
  // rewards; stops when a level ends. Where an episode ends, `before_new_level` is called while its
  // last picture can still be drawn. An episode that has ended before is followed by the next level
  // in place of the action. REQUIRES: !awaits_reset().
  void Step(int32_t action, int32_t repeat, absl::FunctionRef<void()> before_new_level);

  // Whether the episode has ended and only Reset goes on (kDisabled).
  bool awaits_reset() const { return ended_ && autoreset_mode_ == AutoresetMode::kDisabled; }
  const GameSpec& spec() const { return spec_; }

  const StepResult& result() const { return result_; }
  const Game& game() const { return *game_; }
  // Fills `scene` with what is to be seen now; good until the environment moves on.
  void FillScene(Scene* scene) const { game_->FillScene(scene); }

 private:
  // One that has no level yet.
  Environment(const GameSpec& spec, const EnvironmentOptions& options,
              AutoresetMode autoreset_mode);

  // All but what the environment was made with and its level's seed.
  void VisitState(StateArchive& archive);
  void StepOnce(int32_t action, absl::FunctionRef<void()> before_new_level);
  // Chooses the next level and begins it: the one that was told, or one of the sampler's, or the
  // next after a completed one in a sequence, or one by a draw from the options' range.
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
  RandomStream level_stream_;  // the level-seed stream
  std::shared_ptr<const LevelSampler> level_sampler_;
  std::optional<int32_t> next_level_;
  StepResult result_;
  float episode_return_ = 0;  // of the running episode
  int32_t episode_length_ = 0;
  Fingerprint fingerprint_;  // of the running episode
  bool ended_ = false;       // the episode has ended and the next has not begun
  bool is_restored_ = false;
};

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_ENVIRONMENT_H_
