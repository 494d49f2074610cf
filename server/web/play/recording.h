#ifndef SERVER_WEB_PLAY_RECORDING_H_
#define SERVER_WEB_PLAY_RECORDING_H_

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "envcore/trace/trace.h"
#include "server/web/json/message.h"

namespace procgen::web {

// Result of a step, or the state before the first one.
struct Row {
  float reward = 0;
  bool first = false;
  int32_t level_seed = 0;
  int32_t prev_level_seed = 0;
  bool prev_level_complete = false;
  float episode_return = 0;  // of the episode that just ended, else of the running one
  int32_t episode_length = 0;
  std::optional<uint64_t> fingerprint;  // of the episode that just ended, if any
  std::string picture;                  // rgb, 64 x 64 x 3; empty if not requested
  // Last frames of the episode that just ended, if any and if requested.
  std::string final_picture;  // rgb, 64 x 64 x 3
  std::string final_human;    // PNG
};

// A fingerprint as 16 hexadecimal digits, or null.
Json FingerprintJson(std::optional<uint64_t> fingerprint);

// Actions and results of one environment, by row. Row 0 is the state before the first action.
class Recording {
 public:
  // `games` and `options` are those of the environment.
  Recording(std::vector<std::string> games, const EnvironmentOptions& options);

  // Clears the recording and sets row 0.
  void Begin(const Row& row);
  void Add(int32_t action, const Row& row);
  // Removes all rows but the first `row_count`, which is in [1, row_count()].
  void Truncate(int32_t row_count);

  int32_t row_count() const { return trace_.step_count + 1; }
  // Number of finished episodes.
  int32_t episode_count() const { return static_cast<int32_t>(ends_.size()); }
  // A trace of one environment.
  const Trace& trace() const { return trace_; }
  // The JSON of a view at `row`.
  Json ViewOf(int32_t row) const;
  // The members of replay.open for all rows: rewards, first, level_seeds, level_complete, actions,
  // total_reward, fingerprint.
  Json Summary() const;
  // The members of play.trace: game, mode, level_seed, steps, total_reward, fingerprint, file_name.
  Json FileFacts() const;
  // The latest fingerprint up to and including `row`.
  std::optional<uint64_t> FingerprintAt(int32_t row) const;

 private:
  struct End {
    int32_t row = 0;
    std::optional<uint64_t> fingerprint;
  };

  void AddRow(const Row& row);

  Trace trace_;
  std::vector<float> episode_returns_;  // [rows]
  std::vector<int32_t> episode_lengths_;
  std::vector<End> ends_;  // finished episodes, by row
};

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_RECORDING_H_
