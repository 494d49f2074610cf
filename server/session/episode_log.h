#ifndef SERVER_SESSION_EPISODE_LOG_H_
#define SERVER_SESSION_EPISODE_LOG_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/session/byte_budget.h"
#include "server/session/episode.h"
#include "server/session/request.h"
#include "server/session/step_run.h"

namespace procgen {

// Remembers of each environment of a pool the episode under way and the last one that ended.
//
// It is written with each step and hardly ever read. So a step is kept as it comes, as one row of
// actions for all environments, a byte each, and only who reads puts an episode together. Steps
// that no episode needs any more are forgotten in whole runs, and so are the oldest ones where
// there is no room.
// Threads: one at a time (it is changed and read in turns), but what Read returns.
class EpisodeLog {
 public:
  // An episode that is still in pieces, which nobody changes any more.
  class Pieces {
   public:
    // Puts it together. Threads: any.
    Episode Join() const;

   private:
    friend class EpisodeLog;

    Episode episode_;
    int32_t environment_ = 0;
    int64_t begin_ = 0;  // of the steps after this number
    int64_t end_ = 0;    // up to this one
    std::vector<std::shared_ptr<const StepRun>> runs_;
  };

  // How an environment stands that was put into a state.
  struct PutIn {
    int32_t environment = 0;
    std::shared_ptr<const EnvironmentOptions> options;  // null: those of the pool
    int32_t level_seed = 0;
    int32_t episode_length = 0;
    bool awaits_episode = false;   // the next one has not begun
    bool follows_another = false;  // as in Episode
  };

  // Reserves what it takes of `bytes`, which must outlive it, as it grows.
  EpisodeLog(int32_t env_count, ByteBudget* bytes);
  ~EpisodeLog();
  EpisodeLog(const EpisodeLog&) = delete;
  EpisodeLog& operator=(const EpisodeLog&) = delete;

  // A part of a request was carried out, that steps (`input.steps`) or only resets. `batch`: as
  // BatchNumbers lends it.
  void Add(const StepInput& input, const Batch& batch);
  // States were put in.
  void Add(absl::Span<const PutIn> states);
  // Environments were put into the states of others, all at once.
  void Add(absl::Span<const StateToClone> pairs);
  // What happened in [part.first, part.first + part.count) is not known.
  void Lose(Part part, EpisodeLack why);

  // Whether the seed of the level is known that the episode under way began with.
  bool KnowsLevel(int32_t environment) const { return Of(environment).current.knows_level; }
  // Tells it; of an episode that has not been stepped.
  void SetLevel(int32_t environment, int32_t level_seed);

  // An episode of an environment: the one under way, or else the last that ended. Errors:
  // FAILED_PRECONDITION there is none.
  absl::StatusOr<Pieces> Read(int32_t environment, bool under_way);

 private:
  // An episode's beginning.
  struct Beginning {
    int64_t number = 0;  // the steps after this one belong to it
    int32_t level_seed = 0;
    bool knows_level = false;
    EpisodeLack lack = EpisodeLack::kNothing;
    bool follows_another = false;  // as in Episode
    std::shared_ptr<const EnvironmentOptions> options;
  };
  struct Ended {
    Beginning beginning;
    int64_t last_number = 0;
    EpisodeOutcome outcome = EpisodeOutcome::kTerminated;
    bool level_complete = false;
    uint64_t fingerprint = 0;
    float total_reward = 0;
  };
  struct OfEnvironment {
    Beginning current;
    bool is_under_way = true;
    std::optional<Ended> last;
  };

  OfEnvironment& Of(int32_t environment) { return environments_[static_cast<size_t>(environment)]; }
  const OfEnvironment& Of(int32_t environment) const {
    return environments_[static_cast<size_t>(environment)];
  }

  // Adds a row of actions to the run of the slice. Null: there is no room.
  StepRun* AddRow(const StepInput& input, const Batch& batch);
  void AddCounts(const StepInput& input, const Batch& batch, StepRun* run);
  std::shared_ptr<StepRun> OpenRun(Part slice);
  void LearnLevels(const StepInput& input, const Batch& batch);
  // Of a row where something ended or began.
  void AddTurn(int32_t environment, size_t row, const StepInput& input, const Batch& batch,
               StepRun* run);
  // The episode's Beginning::follows_another is known already.
  void Begin(int32_t environment, int32_t level_seed);
  // Makes room, by forgetting what is oldest; false: there is none.
  bool Reserve(int64_t bytes);
  bool IsNeeded(const StepRun& run) const;
  void ForgetUnneeded();
  void ForgetOldest();

  ByteBudget* const bytes_;
  const int64_t bytes_max_;  // of this pool
  int64_t reserved_bytes_ = 0;
  int64_t number_ = 0;  // of the last part that was carried out
  std::vector<OfEnvironment> environments_;
  std::vector<int32_t> lengths_;               // of the episodes under way, in steps; -1: not known
  std::vector<float> returns_;                 // likewise, the sums of their rewards
  int32_t unknown_levels_;                     // environments whose level is not known
  std::deque<std::shared_ptr<StepRun>> runs_;  // oldest first
  std::vector<std::shared_ptr<StepRun>> open_runs_;  // that rows are added to
};

}  // namespace procgen

#endif  // SERVER_SESSION_EPISODE_LOG_H_
