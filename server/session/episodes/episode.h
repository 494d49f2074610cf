#ifndef SERVER_SESSION_EPISODES_EPISODE_H_
#define SERVER_SESSION_EPISODES_EPISODE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "envcore/pool/pool.h"

namespace procgen {

enum class EpisodeOutcome : uint8_t {
  kUnderWay,
  kTerminated,
  kTruncated,
  kReset,  // it was left
};

// Why the beginning of an episode is not known.
enum class IncompleteReason : uint8_t {
  kNone,             // it is
  kStateRestored,    // a state was put into the environment in its midst
  kTooOld,           // it was forgotten
  kServerRestarted,  // it began when another process had the pool
  kRequestFailed,    // a request failed in its midst
};

// A level that began in the midst of an episode.
struct LevelChange {
  int32_t action = 0;  // index of the one that completed the level before
  int32_t level_seed = 0;
};

// An episode as a whole.
struct EpisodeSummary {
  int32_t level_seed = 0;  // of its first level
  // That it was made with; null: those of the pool.
  std::shared_ptr<const EnvironmentOptions> options;
  float total_reward = 0;
  EpisodeOutcome outcome = EpisodeOutcome::kUnderWay;
  bool level_complete = false;  // by the last action
  uint64_t fingerprint = 0;     // at its end; 0: it has none
  IncompleteReason incomplete_reason = IncompleteReason::kNone;
  // An episode came before whose level was not completed; miner remembers that until its first
  // step.
  bool prev_level_incomplete = false;
};

// An episode with its steps.
struct Episode : EpisodeSummary {
  std::string actions;                 // one byte each; 255: kEndEpisodeAction
  std::vector<float> rewards;          // of each of the learner's steps
  std::vector<int32_t> action_counts;  // likewise: how many actions it took; empty: one each
  std::vector<LevelChange> level_changes;
};

}  // namespace procgen

#endif  // SERVER_SESSION_EPISODES_EPISODE_H_
