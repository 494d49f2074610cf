#ifndef SERVER_WEB_PLAY_REPLAY_H_
#define SERVER_WEB_PLAY_REPLAY_H_

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "envcore/trace/trace.h"
#include "server/web/play/recording.h"
#include "server/web/play/single_env_pool.h"

namespace procgen::web {

// What is replayed: one environment of a trace.
struct ReplaySource {
  Trace trace;              // of any number of environments
  int32_t environment = 0;  // which of them
};

// A recording that is played again and looked at row by row, forward and backward, by snapshots of
// every so many rows. All methods block. Threads: one at a time.
class Replay {
 public:
  static constexpr int32_t kRowsMax = 100001;

  // Replays all of it. Errors: INVALID_ARGUMENT the trace has too many rows, no such environment,
  // or actions that there are not; those of the server; CANCELLED `is_stopping`.
  static absl::StatusOr<std::unique_ptr<Replay>> Open(
      std::shared_ptr<procgen_client::Client> client, const ReplaySource& source,
      int32_t human_size_px, const std::atomic<bool>& is_stopping);

  // What is known of it, as replay.open answers.
  const Json& facts() const { return facts_; }
  int32_t row_count() const { return recording_.row_count(); }
  // What came of replaying it.
  const Recording& recording() const { return recording_; }
  // A view. `row`: in [0, row_count()).
  absl::StatusOr<Answer> Seek(int32_t row);

 private:
  Replay(std::unique_ptr<SingleEnvPool> pool, Recording recording, int32_t human_size_px,
         int32_t snapshot_rows);
  absl::Status PlayAll(const Trace& trace, const std::atomic<bool>& is_stopping);
  absl::Status TakeSnapshot(int32_t row);
  // Goes to a row, and shows it.
  absl::StatusOr<Row> GoTo(int32_t row);

  const std::unique_ptr<SingleEnvPool> pool_;
  const int32_t human_size_px_;
  const int32_t snapshot_rows_;  // from one to the next
  Recording recording_;
  std::map<int32_t, procgen::v1::State> snapshots_;  // by row
  int32_t row_ = 0;                                  // where the pool stands
  Json facts_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_REPLAY_H_
