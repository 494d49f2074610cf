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

// How an environment stands after a step, or before the first.
struct Row {
  float reward = 0;
  bool first = false;
  int32_t level_seed = 0;
  int32_t prev_level_seed = 0;
  bool prev_level_complete = false;
  float episode_return = 0;  // of the episode that ended where one did, else of the running one
  int32_t episode_length = 0;
  std::optional<uint64_t> fingerprint;  // of the episode that ended, if one did
  std::string picture;                  // rgb, 64 x 64; empty: not asked for
};

// A fingerprint as pages have it; null: none.
Json FingerprintJson(std::optional<uint64_t> fingerprint);

// What was done in one environment, row by row, and what it answered. Row 0 is before the first
// action.
class Recording {
 public:
  // `games` and `options` are what the environment was made with.
  Recording(std::vector<std::string> games, const EnvironmentOptions& options);

  // Begins anew, with row 0.
  void Begin(const Row& row);
  void Add(int32_t action, const Row& row);

  int32_t row_count() const { return trace_.step_count + 1; }
  // Of one environment.
  const Trace& trace() const { return trace_; }
  // What is known at a row, as a view has it.
  Json ViewOf(int32_t row) const;
  // Of all rows, as a replay has it: rewards, first, level_seeds, level_complete, actions,
  // total_reward, fingerprint.
  Json Summary() const;
  // What goes with a file: game, mode, level_seed, steps, total_reward, fingerprint, file_name.
  Json FileFacts() const;
  // The last fingerprint up to a row.
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
  std::vector<End> ends_;  // episodes that ended, by row
};

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_RECORDING_H_
