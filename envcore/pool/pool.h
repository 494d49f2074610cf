#ifndef ENVCORE_POOL_POOL_H_
#define ENVCORE_POOL_POOL_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/environment/environment.h"
#include "envcore/environment/environment_options.h"
#include "envcore/environment/level_sampler.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/observation_format.h"
#include "envcore/pool/scene_snapshot.h"
#include "envcore/pool/shared_art.h"
#include "envcore/pool/worker_pool.h"

namespace procgen {

class FrameStack;
class StaticLayerCache;

// The side in pixels and the bytes of an observation in the default format: uint8 [64, 64, 3], top
// row first, red, green, blue.
inline constexpr int kObservationSizePx = 64;
inline constexpr int kObservationBytes = kObservationSizePx * kObservationSizePx * 3;
// The sides that the human view can be drawn at, in pixels.
inline constexpr int32_t kHumanViewSizePxMin = 16;
inline constexpr int32_t kHumanViewSizePxMax = 2048;
// Environments of a whole that a pool can be a part of: what a shard skips costs a draw each.
inline constexpr int32_t kTotalEnvCountMax = 1 << 24;
// How often a step can repeat its actions.
inline constexpr int32_t kRepeatMax = 1000;

struct PoolOptions {
  std::vector<std::string> games;  // dealt in turn: environment n plays games[n % games.size()]
  int32_t env_count = 0;           // environments in this pool
  EnvironmentOptions environment;  // the same for all
  AutoresetMode autoreset_mode = AutoresetMode::kSameStep;
  // This pool is environments [first_env, first_env + env_count) of a larger one of
  // total_env_count; environment i of it gives the same episodes as environment
  // first_env + i of the whole.
  int32_t first_env = 0;
  int32_t total_env_count = 0;  // 0: first_env + env_count
  ObservationFormat observation_format;
  // Chooses the levels in place of EnvironmentOptions::num_levels and start_level; null: they do.
  // Environment i of the whole draws by a stream seeded with StreamSeedOf(i).
  std::shared_ptr<const LevelSampler> level_sampler;
  // What is drawn with: pixels depend on it, nothing else does. Null: the built-in art.
  std::shared_ptr<const SharedArt> art;
};

// The level seed that an environment plays next, in place of one drawn.
struct NextLevel {
  int32_t environment = 0;  // index in the pool
  int32_t level_seed = 0;
};

// An environment that begins a new episode in place of being stepped.
struct Reset {
  int32_t environment = 0;            // index in the pool
  std::optional<int32_t> level_seed;  // the level to play; absent: drawn as usual
  std::optional<int64_t> rand_seed;   // seeds the choice of levels anew, before the draw
};

// A snapshot and the environment that is put into it.
struct StateToRestore {
  int32_t environment = 0;  // index in the pool
  absl::string_view snapshot;
};

// An environment that is put into the state of another of the same pool.
struct StateToClone {
  int32_t source_environment = 0;
  int32_t target_environment = 0;
};

// What is asked of the environments [first, first + count). The spans must stay valid until the
// step is done.
struct StepInput {
  int32_t first = 0;
  int32_t count = 0;
  // False: only the resets are carried out, all other environments stay as they are; `actions` is
  // empty then.
  bool steps = true;
  // [count], each in [-1, kActionCount); -1: do nothing and end the episode.
  absl::Span<const int32_t> actions = {};
  // The same action this many times, rewards summed; an environment stops where its level ends.
  int32_t repeat = 1;
  absl::Span<const NextLevel> next_levels = {};  // of environments in the slice, each at most once
  absl::Span<const Reset> resets = {};           // of environments in the slice, each at most once
};

// What is answered. Each span has the length that its comment says for n environments, or is empty:
// then it is not written (an empty `observations` also saves the drawing, but where observations
// are stacks of frames). The caller owns the memory. F: the shape of one observation,
// PoolOptions::observation_format.Shape(), by default 64, 64, 3.
struct Batch {
  absl::Span<uint8_t> observations;         // agent's view, after any new level  [n, F]
  absl::Span<float> rewards;                // of this step, of the old episode   [n]
  absl::Span<uint8_t> first;                // 1: a new episode has begun         [n]
  absl::Span<uint8_t> terminated;           // 1: the game ended the episode      [n]
  absl::Span<uint8_t> truncated;            // 1: the step limit ended it         [n]
  absl::Span<int32_t> level_seeds;          // of the level in the observation    [n]
  absl::Span<int32_t> prev_level_seeds;     // of the level that was stepped      [n]
  absl::Span<uint8_t> prev_level_complete;  // 1: that level was completed        [n]
  // At an episode's end the ended episode's, otherwise of the episode so far.
  absl::Span<float> episode_returns;    // sum of rewards                         [n]
  absl::Span<int32_t> episode_lengths;  // steps                                  [n]
  absl::Span<uint64_t> fingerprints;    // as class Fingerprint defines them      [n]
  // Where the episode ended in this step: its last observation, before the new level. Other rows
  // are left as they were.
  absl::Span<uint8_t> final_observations;  //                                     [n, F]
};

// A Pool steps env_count() environments as one batch.
// Shapes: row i of a batch is environment first + i, whatever order the workers finish in.
// Threads: any method from any thread; a second call that reads or steps environments while one
// runs returns ABORTED at once and changes nothing.
// Determinism: the number of workers, slicing and pool size change no bit of any result.
class Pool {
 public:
  using DoneCallback = absl::AnyInvocable<void(absl::Status)>;

  // Makes a pool; every environment stands at the first step of its first level. `workers` is
  // shared by pools. Errors: NOT_FOUND no such game; INVALID_ARGUMENT an option out of range (the
  // message names it and the range).
  static absl::StatusOr<std::unique_ptr<Pool>> Create(const PoolOptions& options,
                                                      std::shared_ptr<WorkerPool> workers);
  // REQUIRES: no step is running.
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  int32_t env_count() const { return static_cast<int32_t>(environments_.size()); }
  const PoolOptions& options() const { return options_; }
  // Bytes of one environment's observation.
  size_t observation_bytes() const { return options_.observation_format.bytes(); }
  // Whether the episode of `environment` has ended and it must be reset before it is stepped, with
  // AutoresetMode::kDisabled. REQUIRES: an index in the pool, and that no call runs.
  bool AwaitsReset(int32_t environment) const {
    return environments_[static_cast<size_t>(environment)]->awaits_reset();
  }

  // Steps each environment of the slice once (`repeat` times) on the calling thread and the worker
  // pool.
  // On error nothing has moved. Errors: INVALID_ARGUMENT wrong length, an action or index out of
  // range; FAILED_PRECONDITION with AutoresetMode::kDisabled, an environment whose episode has
  // ended and is not reset; ABORTED another call runs.
  absl::Status Step(const StepInput& input, const Batch& batch);
  // As Step, on the worker pool alone, and returns at once. When all is done `done` is called once,
  // on a worker thread; it must not block. It may step the pool again or end it, but not the worker
  // pool. The spans must stay valid until then. With an error, and for a single environment (which
  // is stepped sooner than handed over), `done` is called before StepAsync returns, on the calling
  // thread.
  // REQUIRES: the worker pool has a thread.
  void StepAsync(const StepInput& input, const Batch& batch, DoneCallback done);

  // Writes what the environments [first, first + count) show now, as after their last step, without
  // stepping. Errors: INVALID_ARGUMENT, ABORTED as in Step.
  absl::Status Observe(int32_t first, int32_t count, const Batch& batch);

  // Replaces what chooses levels; takes effect at each environment's next choice, which is the
  // first of a stream seeded anew. Restored and cloned states draw from it, too, each from where
  // its own stream stands. `level_sampler`: not null. Errors: ABORTED as in Step.
  absl::Status SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler);

  // Snapshots of `environments`, in their order, taken on the calling thread. Errors:
  // INVALID_ARGUMENT an index out of range; ABORTED as in Step.
  absl::StatusOr<std::vector<std::string>> SaveStates(absl::Span<const int32_t> environments);

  // Puts environments into saved states, options included, on the calling thread; what they show
  // next is what was shown last (of a stack of frames the last one, in all places: a snapshot holds
  // no pictures). What follows an episode's end stays as PoolOptions say; one that
  // was saved between two episodes begins the next with its next step or, with kDisabled, a reset.
  // On error nothing has changed. Errors: INVALID_ARGUMENT an index out of range or named twice, a
  // snapshot with a value out of range; FAILED_PRECONDITION one of another game; DATA_LOSS one that
  // is damaged or of another version; ABORTED as in Step.
  absl::Status RestoreStates(absl::Span<const StateToRestore> states);

  // Puts environments into the states of others, on the calling thread. All are read before any is
  // written, so states can be exchanged. On error nothing has changed. Errors: INVALID_ARGUMENT an
  // index out of range, a target named twice; FAILED_PRECONDITION environments of different games;
  // ABORTED as in Step.
  absl::Status CloneStates(absl::Span<const StateToClone> pairs);

  // Draws the human view of one environment, antialiased, on the calling thread. `frame`: uint8
  // [size_px, size_px, 3]. Errors: INVALID_ARGUMENT index or side out of range
  // ([kHumanViewSizePxMin, kHumanViewSizePxMax]) or a frame of another size; ABORTED as in Step.
  absl::Status Render(int32_t environment, int32_t size_px, absl::Span<uint8_t> frame);

  // What one environment shows now, to be drawn later; much cheaper than Render. Errors:
  // INVALID_ARGUMENT an index out of range; ABORTED as in Step.
  absl::StatusOr<SceneSnapshot> CaptureScene(int32_t environment);

 private:
  class StepJob;
  struct WorkerScratch;

  Pool(const PoolOptions& options, std::shared_ptr<WorkerPool> workers);

  // Takes the pool for one call; false if another has it.
  bool Take() { return !busy_.exchange(true, std::memory_order_acquire); }
  void Release() { busy_.store(false, std::memory_order_release); }
  // Hands what concerns few environments to them.
  void ApplySparse(const StepInput& input);
  absl::Status CheckIndex(int32_t environment) const;
  absl::StatusOr<std::vector<std::string>> SaveTaken(absl::Span<const int32_t> environments);
  absl::Status RestoreTaken(absl::Span<const StateToRestore> states);
  absl::Status CheckNoneAwaitsReset(const StepInput& input) const;
  // Checks a step, takes the pool and carries out what concerns few environments.
  absl::Status Begin(const StepInput& input, const Batch& batch);
  // The art of the game that environment `index` of this pool plays.
  const std::shared_ptr<const GameArt>& ArtOf(size_t index) const;

  const PoolOptions options_;
  const std::shared_ptr<WorkerPool> workers_;
  std::shared_ptr<const LevelSampler> level_sampler_;  // null: the options choose
  std::vector<std::unique_ptr<Environment>> environments_;
  std::vector<std::shared_ptr<const GameArt>> art_;  // by index in options_.games
  std::vector<StaticLayerCache> static_layers_;      // [N]
  std::vector<FrameStack> frame_stacks_;             // [N]; empty: of one frame each
  std::vector<const Reset*> resets_;                 // [N] of the running step; null: none
  std::vector<std::unique_ptr<WorkerScratch>> worker_scratch_;  // by worker number
  std::unique_ptr<StepJob> job_;
  std::atomic<bool> busy_ = false;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_POOL_H_
