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
#include "envcore/status/status.h"

namespace procgen {

class FrameStack;
class StaticLayerCache;

// The centre of an agent in an image of its whole level, which is in the middle of a square: in
// fractions of the image's width from the left, and of its height from the top.
struct AgentPosition {
  float x = 0;
  float y = 0;
};

// Size in pixels and in bytes of an observation in the default format: uint8 [64, 64, 3], top row
// first, RGB.
inline constexpr int kObservationSizePx = 64;
inline constexpr int kObservationBytes = kObservationSizePx * kObservationSizePx * 3;
// Range of the size of the human view, in pixels.
inline constexpr int32_t kHumanViewSizePxMin = 16;
inline constexpr int32_t kHumanViewSizePxMax = 2048;
// Largest PoolOptions::total_env_count. Create takes one random draw for each environment before
// first_env.
inline constexpr int32_t kTotalEnvCountMax = 1 << 24;
// Largest number of objects of an environment that ReadObjects writes.
inline constexpr int32_t kObjectsMax = 4096;
// Largest StepInput::repeat.
inline constexpr int32_t kRepeatMax = 1000;

// The options of a pool. `observation_format` and `art` change pixels only, never levels, rewards
// or episode ends.
struct PoolOptions {
  std::vector<std::string> games;  // environment n of the whole pool plays games[n % games.size()]
  int32_t env_count = 0;           // environments in this pool
  EnvironmentOptions environment;  // for all environments
  AutoresetMode autoreset_mode = AutoresetMode::kSameStep;
  // For a shard of a larger pool. This pool holds environments [first_env, first_env + env_count)
  // of a whole pool of total_env_count environments. Its environment i plays the same episodes as
  // environment first_env + i of the whole pool. total_env_count is at most kTotalEnvCountMax and a
  // multiple of the number of games.
  int32_t first_env = 0;
  int32_t total_env_count = 0;  // 0: first_env + env_count
  ObservationFormat observation_format;
  // Chooses the levels instead of EnvironmentOptions::num_levels and start_level. Null: those
  // options do. The level-seed stream of environment i of the whole pool is seeded with
  // LevelSampler::StreamSeedOf(i).
  std::shared_ptr<const LevelSampler> level_sampler;
  // The art to draw with. It changes pixels only. Null: the built-in art.
  std::shared_ptr<const SharedArt> art;
};

// Overrides the next draw of a level seed for one environment.
struct NextLevel {
  int32_t environment = 0;  // index in the pool
  int32_t level_seed = 0;
};

// Begins a new episode in one environment instead of stepping it.
struct Reset {
  int32_t environment = 0;            // index in the pool
  std::optional<int32_t> level_seed;  // the level to play; absent: chosen as after any episode
  std::optional<int64_t> rand_seed;   // reseeds the level-seed stream before the level is chosen
};

// A snapshot to restore into an environment.
struct StateToRestore {
  int32_t environment = 0;  // index in the pool
  absl::string_view snapshot;
};

// A copy of one environment's state into another environment of the same pool.
struct StateToClone {
  int32_t source_environment = 0;
  int32_t target_environment = 0;
};

// A step of the environments [first, first + count). The spans must stay valid until the step is
// done.
struct StepInput {
  int32_t first = 0;
  int32_t count = 0;
  // False: only `resets` are executed and the other environments stay as they are. `actions` must
  // be empty then.
  bool steps = true;
  // [count], each in [-1, kActionCount). -1 (kEndEpisodeAction) does nothing and ends the episode.
  absl::Span<const int32_t> actions = {};
  // Number of times the action is repeated, in [1, kRepeatMax]. Rewards are summed. An environment
  // stops repeating when its level ends.
  int32_t repeat = 1;
  absl::Span<const NextLevel> next_levels = {};  // in the slice, each environment at most once
  absl::Span<const Reset> resets = {};           // in the slice, each environment at most once
};

// The results of a step of n environments, written into memory that the caller owns. Each span has
// the length given below, or is empty and is not written. An empty `observations` also skips
// rendering, unless frame_stack is above 1. F: the shape of one observation,
// PoolOptions::observation_format.Shape(); 64, 64, 3 by default.
struct Batch {
  absl::Span<uint8_t> observations;         // agent's view, after any new level    [n, F]
  absl::Span<float> rewards;                // of this step, for the old episode    [n]
  absl::Span<uint8_t> first;                // 1: a new episode has begun           [n]
  absl::Span<uint8_t> terminated;           // 1: the game ended the episode        [n]
  absl::Span<uint8_t> truncated;            // 1: the step limit ended it           [n]
  absl::Span<int32_t> level_seeds;          // of the level in the observation      [n]
  absl::Span<int32_t> prev_level_seeds;     // of the level that was stepped        [n]
  absl::Span<uint8_t> prev_level_complete;  // 1: that level was completed          [n]
  // Of the episode that ended in this step, else of the running episode so far.
  absl::Span<float> episode_returns;    // sum of rewards                           [n]
  absl::Span<int32_t> episode_lengths;  // steps                                    [n]
  absl::Span<uint64_t> fingerprints;    // as defined by class Fingerprint          [n]
  // The last observation of each episode that ended in this step, drawn before the new level
  // begins. Other rows are not written.
  absl::Span<uint8_t> final_observations;  //                                       [n, F]
  // Scenes to capture when an episode ends in this step, before the new level begins. The caller
  // sets each `environment`, in increasing order, and a null `scene`; the step sets `scene` where
  // an episode ended. Its length is that of the list, not n.
  absl::Span<FinalScene> final_scenes;
};

// The arrays of a Batch that have one number per environment: NUMBERS(type, name, member of
// StepResult). What writes, copies, checks or sends a batch is made from this table.
#define PROCGEN_BATCH_NUMBERS(NUMBERS)                       \
  NUMBERS(float, rewards, reward)                            \
  NUMBERS(uint8_t, first, first)                             \
  NUMBERS(uint8_t, terminated, terminated)                   \
  NUMBERS(uint8_t, truncated, truncated)                     \
  NUMBERS(int32_t, level_seeds, level_seed)                  \
  NUMBERS(int32_t, prev_level_seeds, prev_level_seed)        \
  NUMBERS(uint8_t, prev_level_complete, prev_level_complete) \
  NUMBERS(float, episode_returns, episode_return)            \
  NUMBERS(int32_t, episode_lengths, episode_length)          \
  NUMBERS(uint64_t, fingerprints, fingerprint)

// The bytes of each of these numbers.
#define PROCGEN_BYTES(type, name, member) sizeof(type),
inline constexpr size_t kBatchNumberBytes[] = {PROCGEN_BATCH_NUMBERS(PROCGEN_BYTES)};
#undef PROCGEN_BYTES

// A Pool steps env_count() environments as one batch.
// Shapes: row i of a batch is environment first + i.
// Threads: thread-safe. Only one call at a time can step or read environments: a second one returns
// ABORTED immediately and changes nothing.
// Determinism: the number of workers, the slices and the pool size change no bit of any result.
class Pool {
 public:
  using DoneCallback = absl::AnyInvocable<void(Status)>;

  // Makes a pool. Every environment is at the first step of its first level. Several pools can
  // share `workers`. Errors: NOT_FOUND: no such game. INVALID_ARGUMENT: an option is out of range
  // (the message gives its value and the range).
  static StatusOr<std::unique_ptr<Pool>> Create(const PoolOptions& options,
                                                std::shared_ptr<WorkerPool> workers);
  // REQUIRES: no step is running.
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  int32_t env_count() const { return static_cast<int32_t>(environments_.size()); }
  const PoolOptions& options() const { return options_; }
  // Bytes of one environment's observation.
  size_t observation_bytes() const { return options_.observation_format.bytes(); }
  // Whether `environment` needs a reset before it can be stepped: its episode has ended and the
  // mode is AutoresetMode::kDisabled. REQUIRES: an index in the pool; no other call is running.
  bool AwaitsReset(int32_t environment) const {
    return environments_[static_cast<size_t>(environment)]->awaits_reset();
  }

  // Steps each environment of the slice `repeat` times, on the calling thread and the worker pool.
  // Returns when all are done. On error no environment has changed.
  // Errors: INVALID_ARGUMENT: wrong length, or an action or index out of range.
  // FAILED_PRECONDITION: with AutoresetMode::kDisabled, an environment whose episode has ended is
  // not reset. ABORTED: another call is running.
  Status Step(const StepInput& input, const Batch& batch);
  // Like Step, but on the worker pool only, and returns immediately. `done` is called once, on a
  // worker thread, when all environments are done; it must not block. `done` may step or destroy
  // this pool, but must not destroy the worker pool. The spans must stay valid until `done` is
  // called.
  // On an error, and for a slice of one environment with a small `repeat`, `done` is called on the
  // calling thread before StepAsync returns: stepping one environment is faster than handing it
  // over. REQUIRES: the worker pool has at least one thread.
  void StepAsync(const StepInput& input, const Batch& batch, DoneCallback done);

  // Writes the current results of the environments [first, first + count), as after their last
  // step, without stepping. Errors: INVALID_ARGUMENT, ABORTED as in Step.
  Status Observe(int32_t first, int32_t count, const Batch& batch);

  // Replaces the level sampler and reseeds each environment's level-seed stream for it. It takes
  // effect at each environment's next choice of a level. States that are restored or cloned later
  // use it too, each from the position of its own stream. `level_sampler`: not null. Errors:
  // ABORTED as in Step.
  Status SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler);

  // Returns snapshots of `environments`, in the same order. Runs on the calling thread. Errors:
  // INVALID_ARGUMENT: an index is out of range. ABORTED as in Step.
  StatusOr<std::vector<std::string>> SaveStates(absl::Span<const int32_t> environments);

  // Restores environments from snapshots, options included. Runs on the calling thread. The next
  // observation equals the last one before the snapshot; a frame stack holds its last frame in all
  // places, because snapshots contain no pixels. The autoreset mode stays that of PoolOptions. An
  // environment saved between two episodes begins the next one with its next step or, with
  // kDisabled, with a reset. On error nothing has changed.
  // Errors: INVALID_ARGUMENT: an index is out of range or named twice, or a snapshot has a value
  // out of range. FAILED_PRECONDITION: the snapshot is of another game. DATA_LOSS: the snapshot is
  // damaged or of another version. ABORTED as in Step.
  Status RestoreStates(absl::Span<const StateToRestore> states);

  // Copies states between environments. Runs on the calling thread. All sources are read before any
  // target is written, so environments can swap states. On error nothing has changed. Errors:
  // INVALID_ARGUMENT: an index is out of range, or a target is named twice. FAILED_PRECONDITION:
  // the environments play different games. ABORTED as in Step.
  Status CloneStates(absl::Span<const StateToClone> pairs);

  // Writes the objects of the environments [first, first + count), in the order of ReadObjects.
  // `rows`: [count, objects_max], environment first; unused ones have kind -1. `counts`: [count],
  // the number of objects, which can exceed objects_max. Runs on the calling thread. Errors:
  // INVALID_ARGUMENT: the slice, objects_max or a length is out of range. ABORTED as in Step.
  Status ReadObjects(int32_t first, int32_t count, int32_t objects_max, absl::Span<ObjectRow> rows,
                     absl::Span<int32_t> counts);

  // Draws the antialiased human view of one environment, or its whole level. Runs on the calling
  // thread. `frame`: uint8 [size_px, size_px, 3], RGB. Errors: INVALID_ARGUMENT: the index or
  // size_px is out of range
  // ([kHumanViewSizePxMin, kHumanViewSizePxMax]), or `frame` has another size. ABORTED as in Step.
  Status Render(int32_t environment, int32_t size_px, absl::Span<uint8_t> frame,
                bool whole_level = false);

  // Captures the scene of one environment for later rendering; much cheaper than Render. Errors:
  // INVALID_ARGUMENT: the index is out of range. ABORTED as in Step. `whole_level`: the scene shows
  // the whole level, and not what the agent sees of it.
  StatusOr<SceneSnapshot> CaptureScene(int32_t environment, bool whole_level = false);

  // Returns where the agent of one environment is in an image of its whole level. Errors:
  // INVALID_ARGUMENT: the index is out of range. ABORTED as in Step.
  StatusOr<AgentPosition> FindAgent(int32_t environment);

 private:
  class StepJob;
  struct WorkerScratch;

  Pool(const PoolOptions& options, std::shared_ptr<WorkerPool> workers);

  // Claims the pool for one call. Returns false if another call holds it.
  bool Take() { return !busy_.exchange(true, std::memory_order_acquire); }
  void Release() { busy_.store(false, std::memory_order_release); }
  // Applies `next_levels` and stores `resets` by environment.
  void ApplySparse(const StepInput& input);
  Status CheckIndex(int32_t environment) const;
  StatusOr<std::vector<std::string>> SaveTaken(absl::Span<const int32_t> environments);
  Status RestoreTaken(absl::Span<const StateToRestore> states);
  Status CheckNoneAwaitsReset(const StepInput& input) const;
  // Checks a step, claims the pool and applies the sparse inputs.
  Status Begin(const StepInput& input, const Batch& batch);
  // The art of the game that environment `index` of this pool plays.
  const std::shared_ptr<const GameArt>& ArtOf(size_t index) const;

  const PoolOptions options_;
  const std::shared_ptr<WorkerPool> workers_;
  std::shared_ptr<const LevelSampler> level_sampler_;  // null: the options choose levels
  std::vector<std::unique_ptr<Environment>> environments_;
  std::vector<std::shared_ptr<const GameArt>> art_;  // by index in options_.games
  std::vector<StaticLayerCache> static_layers_;      // [N]
  std::vector<FrameStack> frame_stacks_;             // [N]; empty when frame_stack is 1
  std::vector<const Reset*> resets_;                 // [N], of the running step; null: no reset
  std::vector<std::unique_ptr<WorkerScratch>> worker_scratch_;  // by worker number
  std::unique_ptr<StepJob> job_;
  std::atomic<bool> busy_ = false;
};

// As Pool::ReadObjects, of snapshots. Errors: as Environment::RestoreAny; INVALID_ARGUMENT: a
// length is out of range.
Status ReadObjectsOf(absl::Span<const std::string> snapshots, int32_t objects_max,
                     absl::Span<ObjectRow> rows, absl::Span<int32_t> counts);

}  // namespace procgen

#endif  // ENVCORE_POOL_POOL_H_
