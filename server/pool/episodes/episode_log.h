#ifndef SERVER_POOL_EPISODES_EPISODE_LOG_H_
#define SERVER_POOL_EPISODES_EPISODE_LOG_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/pool/episodes/annotation.h"
#include "server/pool/episodes/episode.h"
#include "server/pool/episodes/episode_recording.h"
#include "server/pool/quota/byte_budget.h"

namespace procgen {

// Records the current episode and the last one that ended, for each environment of a pool.
//
// Each environment has two append buffers, which swap roles when an episode ends. A full buffer is
// doubled. If the budget does not allow that, the environment drops its own oldest steps: first
// those of the ended episode, then those of the current one. Annotations are dropped before steps.
// Threads: one call at a time (it is used in turns).
class EpisodeLog {
 public:
  // The state of an environment after a restore.
  struct RestoredState {
    int32_t environment = 0;
    std::shared_ptr<const EnvironmentOptions> options;  // null: those of the pool
    int32_t level_seed = 0;
    int32_t episode_length = 0;
    bool awaits_episode = false;         // the next episode has not begun
    bool prev_level_incomplete = false;  // as in Episode
  };

  // Reserves memory from `bytes`, which must outlive it, as it grows.
  EpisodeLog(int32_t env_count, ByteBudget* bytes);
  ~EpisodeLog();
  EpisodeLog(const EpisodeLog&) = delete;
  EpisodeLog& operator=(const EpisodeLog&) = delete;

  // The annotations of a step, of which `input` is a part or all.
  struct StepAnnotations {
    absl::Span<const Annotation> annotations;
    int32_t first = 0;  // environments [first, first + count)
    int32_t count = 0;
  };

  // Records an executed part of a request: a step (`input.steps`) or resets alone. `batch`: as
  // BatchNumbers provides it.
  void Add(const StepInput& input, const Batch& batch, const StepAnnotations& annotations);
  // Records restored states.
  void Add(absl::Span<const RestoredState> states);
  // Records environments that were set to the states of others, all at once.
  void Add(absl::Span<const StateToClone> pairs);

  // Whether the first level seed of the current episode is known.
  bool KnowsLevel(int32_t environment) const { return Of(environment).knows_level; }
  // Sets it. REQUIRES: the episode has no steps yet.
  void SetLevel(int32_t environment, int32_t level_seed);

  // Returns a copy of an environment's episode: the current one or the last that ended. Errors:
  // FAILED_PRECONDITION there is none.
  absl::StatusOr<EpisodeRecording> Read(int32_t environment, bool under_way) const;

 private:
  struct Environment {
    EpisodeRecording current;
    bool knows_level = false;
    bool is_under_way = true;
    bool has_last = false;
    EpisodeRecording last;
  };

  Environment& Of(int32_t environment) { return environments_[static_cast<size_t>(environment)]; }
  const Environment& Of(int32_t environment) const {
    return environments_[static_cast<size_t>(environment)];
  }

  void AddStep(const StepInput& input, const Batch& batch, const StepAnnotations& annotations,
               size_t row);
  // Records the annotations of the step that was just added to the current episode. Without memory
  // for them the environment drops older ones.
  void AddAnnotations(const StepAnnotations& annotations, int32_t index);
  // Reserves memory for annotations from the first half of the budget.
  bool ReserveAnnotations(int64_t bytes);
  void ReleaseAnnotations(int64_t bytes);
  // Frees the annotations of the environment's episodes, first those of the ended one. Returns
  // false if there are none.
  bool DropAnnotations(Environment* environment);
  // As EpisodeRecording::ClearSteps and KeepLast.
  void ClearSteps(EpisodeRecording* recording);
  void Forget(EpisodeRecording* recording, int64_t bytes);
  // Handles a row where an episode or a level ended or began.
  void AddBoundary(int32_t index, const Batch& batch, size_t row);
  // Makes the current episode the last one. REQUIRES: its summary is complete.
  void EndEpisode(Environment* environment);
  // REQUIRES: EpisodeSummary::prev_level_incomplete is set.
  void BeginEpisode(int32_t environment, int32_t level_seed);
  // Makes room for a step, dropping the environment's oldest steps if needed. No room remains if
  // the budget allows no step.
  void MakeRoom(Environment* environment);
  // Changes the capacity of a recording's buffer. Returns false if the budget is exceeded.
  bool Reallocate(EpisodeRecording* recording, int64_t capacity);

  ByteBudget* const bytes_;
  const int64_t bytes_max_;                       // of this pool
  int64_t reserved_bytes_ = 0;                    // for steps
  int64_t annotation_bytes_ = 0;                  // for annotations
  std::vector<StepAnnotation> step_annotations_;  // of the row being recorded
  std::vector<float> coarse_map_;                 // likewise, its saliency
  std::vector<Environment> environments_;
  std::vector<int32_t> lengths_;  // of the current episodes, in steps; -1: unknown
  std::vector<float> returns_;    // likewise, the sums of their rewards
};

}  // namespace procgen

#endif  // SERVER_POOL_EPISODES_EPISODE_LOG_H_
