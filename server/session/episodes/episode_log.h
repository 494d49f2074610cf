#ifndef SERVER_SESSION_EPISODES_EPISODE_LOG_H_
#define SERVER_SESSION_EPISODES_EPISODE_LOG_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/session/backend/request.h"
#include "server/session/episodes/episode.h"
#include "server/session/episodes/episode_recording.h"
#include "server/session/quota/byte_budget.h"

namespace procgen {

// Records of each environment of a pool the episode under way and the last one that ended.
//
// Each environment has two append buffers, which swap roles when an episode ends. A buffer that is
// full is doubled. Where the budget has no room for that, the environment forgets its own oldest
// steps: first those of the episode that ended, then those of the one under way.
// Threads: one at a time (it is written and read in turns).
class EpisodeLog {
 public:
  // How an environment stands whose state was restored.
  struct RestoredState {
    int32_t environment = 0;
    std::shared_ptr<const EnvironmentOptions> options;  // null: those of the pool
    int32_t level_seed = 0;
    int32_t episode_length = 0;
    bool awaits_episode = false;         // the next one has not begun
    bool prev_level_incomplete = false;  // as in Episode
  };

  // Reserves what it takes of `bytes`, which must outlive it, as it grows.
  EpisodeLog(int32_t env_count, ByteBudget* bytes);
  ~EpisodeLog();
  EpisodeLog(const EpisodeLog&) = delete;
  EpisodeLog& operator=(const EpisodeLog&) = delete;

  // A part of a request was carried out, that steps (`input.steps`) or only resets. `batch`: as
  // BatchNumbers lends it.
  void Add(const StepInput& input, const Batch& batch);
  // States were restored.
  void Add(absl::Span<const RestoredState> states);
  // Environments were put into the states of others, all at once.
  void Add(absl::Span<const StateToClone> pairs);
  // What happened in [part.first, part.first + part.count) is not known.
  void Lose(Part part, IncompleteReason reason);

  // Whether the seed of the level is known that the episode under way began with.
  bool KnowsLevel(int32_t environment) const { return Of(environment).knows_level; }
  // Tells it; of an episode that has not been stepped.
  void SetLevel(int32_t environment, int32_t level_seed);

  // A copy of an environment's episode: the one under way, or else the last that ended. Errors:
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

  void AddStep(const StepInput& input, const Batch& batch, size_t row);
  // Of a row where something ended or began.
  void AddBoundary(int32_t environment, const Batch& batch, size_t row);
  // The episode under way becomes the last one; its summary is complete.
  static void EndEpisode(Environment* environment);
  // The episode's EpisodeSummary::prev_level_incomplete is known already.
  void BeginEpisode(int32_t environment, int32_t level_seed);
  // Makes room for a step, by forgetting the environment's oldest if need be. None: no step fits.
  void MakeRoom(Environment* environment);
  // Changes the capacity of a recording's buffer; false: the budget has no room.
  bool Reallocate(EpisodeRecording* recording, int64_t capacity);

  ByteBudget* const bytes_;
  const int64_t bytes_max_;  // of this pool
  int64_t reserved_bytes_ = 0;
  std::vector<Environment> environments_;
  std::vector<int32_t> lengths_;  // of the episodes under way, in steps; -1: not known
  std::vector<float> returns_;    // likewise, the sums of their rewards
};

}  // namespace procgen

#endif  // SERVER_SESSION_EPISODES_EPISODE_LOG_H_
