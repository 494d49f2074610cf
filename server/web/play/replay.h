#ifndef SERVER_WEB_PLAY_REPLAY_H_
#define SERVER_WEB_PLAY_REPLAY_H_

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "envcore/trace/trace.h"
#include "server/web/play/agent_path.h"
#include "server/web/play/recording.h"
#include "server/web/play/single_env_pool.h"

namespace procgen::web {

// The input of a replay: one environment of a trace.
struct ReplaySource {
  Trace trace;              // of any number of environments
  int32_t environment = 0;  // index into the trace
};

// A row of a replay, from which a play can continue.
struct Branch {
  procgen::v1::PoolSpec spec;  // of a pool that can restore `state`
  procgen::v1::State state;
  Recording recording;  // up to the row
  Row row;
};

// A replayed recording with random access to its rows, through periodic snapshots. All methods
// block. Threads: one at a time.
class Replay {
 public:
  static constexpr int32_t kRowsMax = 100001;
  static constexpr int32_t kMapSizePxMin = 64;
  static constexpr int32_t kMapSizePxMax = 1024;

  // Replays the whole recording. Errors: INVALID_ARGUMENT the trace has too many rows, no such
  // environment, or invalid actions; those of the server; CANCELLED `is_stopping`.
  static absl::StatusOr<std::unique_ptr<Replay>> Open(
      std::shared_ptr<procgen_client::Client> client, const ReplaySource& source,
      int32_t human_size_px, const std::atomic<bool>& is_stopping);

  // The answer of replay.open.
  const Json& facts() const { return facts_; }
  int32_t row_count() const { return recording_.row_count(); }
  // The result of the replay.
  const Recording& recording() const { return recording_; }
  // Returns the view of `row`, with a map unless `map_size_px` is 0: an image of the whole level,
  // and the path of the agent. Errors: INVALID_ARGUMENT there is no such row; those of the server.
  absl::StatusOr<Answer> Seek(int32_t row, int32_t map_size_px);
  // Returns the branch at `row`. Errors: as Seek.
  absl::StatusOr<Branch> BranchAt(int32_t row);

 private:
  Replay(std::unique_ptr<SingleEnvPool> pool, Recording recording, int32_t human_size_px,
         int32_t snapshot_rows);
  absl::Status PlayAll(const Trace& trace, const std::atomic<bool>& is_stopping);
  absl::Status TakeSnapshot(int32_t row);
  // Moves the pool to `row` and returns it.
  absl::StatusOr<Row> GoTo(int32_t row);
  // Adds the map of `row`, at which the pool is.
  absl::Status AddMap(int32_t row, int32_t map_size_px, Answer* answer);

  const std::unique_ptr<SingleEnvPool> pool_;
  const int32_t human_size_px_;
  const int32_t snapshot_rows_;  // rows between snapshots
  Recording recording_;
  std::map<int32_t, procgen::v1::State> snapshots_;  // by row
  int32_t row_ = 0;                                  // the current row of the pool
  std::optional<AgentPath> path_;                    // of the last map; none: no map was drawn
  Json facts_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_REPLAY_H_
