#ifndef SERVER_POOL_EPISODES_EPISODE_H_
#define SERVER_POOL_EPISODES_EPISODE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "envcore/pool/pool.h"
#include "server/pool/episodes/annotation_recording.h"

namespace procgen {

enum class EpisodeOutcome : uint8_t {
  kUnderWay,
  kTerminated,
  kTruncated,
  kReset,  // ended by a reset
};

// Why the beginning of an episode is missing.
enum class IncompleteReason : uint8_t {
  kNone,           // it is complete
  kStateRestored,  // a state was restored into the environment mid-episode
  kTooOld,         // the oldest steps were dropped to save memory
};

// A level that began within an episode.
struct LevelChange {
  int32_t action = 0;  // index of the action that completed the previous level
  int32_t level_seed = 0;
};

// An episode without its steps.
struct EpisodeSummary {
  int32_t level_seed = 0;  // of its first level
  // The options that it was made with; null: those of the pool.
  std::shared_ptr<const EnvironmentOptions> options;
  float total_reward = 0;
  EpisodeOutcome outcome = EpisodeOutcome::kUnderWay;
  bool level_complete = false;  // by the last action
  uint64_t fingerprint = 0;     // at its end; 0: none
  IncompleteReason incomplete_reason = IncompleteReason::kNone;
  // The previous episode ended with its level incomplete. Miner depends on this until its first
  // step.
  bool prev_level_incomplete = false;
};

// An episode with its steps.
struct Episode : EpisodeSummary {
  std::string actions;                 // one byte each; 255: kEndEpisodeAction
  std::vector<float> rewards;          // one per step of the learner
  std::vector<int32_t> action_counts;  // likewise: actions in the step; empty: one each
  std::vector<LevelChange> level_changes;
  std::vector<AnnotationSeries> annotations;  // steps are indices of `rewards`
};

}  // namespace procgen

#endif  // SERVER_POOL_EPISODES_EPISODE_H_
