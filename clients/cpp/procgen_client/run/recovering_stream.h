#ifndef PROCGEN_CLIENT_RUN_RECOVERING_STREAM_H_
#define PROCGEN_CLIENT_RUN_RECOVERING_STREAM_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "grpcpp/support/byte_buffer.h"
#include "procgen/v1/run.pb.h"
#include "procgen_client/run/run_stream.h"

namespace procgen_client {

absl::Time SteadyNow();

// The time, real or simulated.
struct RunClock {
  std::function<absl::Time()> now;
  std::function<void(absl::Duration)> sleep;

  static RunClock Steady();
};

struct RecoveryOptions {
  // Time to continue after the connection broke. 0: a broken connection ends the pool.
  absl::Duration reconnect_timeout = absl::Minutes(1);
  // Time that a server has to create the pool, after which another one is tried.
  absl::Duration attempt_timeout = absl::InfiniteDuration();
  // Smallest time between two checkpoints. Larger pools wait longer, so that saving takes at most
  // 1 % of the time.
  absl::Duration checkpoint_interval = absl::Seconds(5);
  // Asked after each checkpoint: whether there is a better server, on which the pool then
  // continues. Null: no.
  std::function<bool()> has_better_server = nullptr;
  // Largest request that the server accepts, and largest response that it sends, in bytes.
  int64_t request_bytes_max = 4 << 20;
  int64_t response_bytes_max = 64 << 20;
};

// Number of environments whose states are saved by one request: some kilobytes each.
int32_t StatesPerRequest(int64_t response_bytes_max);

// The requests of a pool on a server, executed exactly once whatever happens to connections and
// servers.
//
// It keeps what is needed to make the pool again: the first request, the last checkpoint (snapshots
// of all environments), and the requests since. When a call breaks, it opens another one, restores
// the checkpoint, repeats the requests without results, and sends the unanswered ones again.
// The engine is exact, so responses are those of an undisturbed call, bit for bit. Checkpoints
// are taken when nothing is unanswered, so that the server saves while the learner computes.
//
// A request that the server rejects ends the call, too: it is dropped, and the pool is made again.
// Threads: one at a time; Cancel from any thread.
class RecoveringStream {
 public:
  // `start`: with all seeds set. `open` begins a call, on the same or on another server.
  RecoveringStream(procgen::v1::StartPool start, const RecoveryOptions& options, OpenRunStream open,
                   RunClock clock = RunClock::Steady());
  ~RecoveringStream();
  RecoveringStream(const RecoveringStream&) = delete;
  RecoveringStream& operator=(const RecoveringStream&) = delete;

  // Creates the pool. Errors: those of the server; UNAVAILABLE; CANCELLED.
  absl::StatusOr<procgen::v1::Started> Start();

  // Sends a request, other than `start`. Does not block.
  void Send(procgen::v1::RunPoolRequest request);
  // Waits for the response to the oldest unanswered request and returns it, serialised. Nothing:
  // the time is over. Errors: of the request, which has changed nothing, if ended() is OK
  // afterwards; else ended(). REQUIRES: a request is unanswered.
  std::optional<absl::StatusOr<grpc::ByteBuffer>> Receive(absl::Duration timeout);
  int64_t unanswered_count() const { return unanswered_count_; }

  // Ends the call, so that the server frees the pool; waits for that, but at most `timeout`.
  void Close(absl::Duration timeout);

  // Ends the call: Receive and ended() return `status`, which is not OK.
  void SetEnded(absl::Status status);

  // Why the pool cannot go on; OK while it can.
  const absl::Status& ended() const { return ended_; }
  // Number of calls that were opened.
  int64_t call_count() const { return call_count_; }
  int64_t checkpoint_count() const { return checkpoint_count_; }

  // Ends the call and all waits with CANCELLED. From any thread.
  void Cancel();

 private:
  // A request since the last checkpoint.
  struct Entry {
    procgen::v1::RunPoolRequest request;
    int64_t bytes = 0;
    bool is_checkpoint = false;  // saves states for the next checkpoint
    bool is_answered = false;
    bool is_dropped = false;  // is not repeated
  };

  Entry& At(int64_t number) { return log_[static_cast<size_t>(number - log_begin_)]; }
  int64_t log_end() const { return log_begin_ + static_cast<int64_t>(log_.size()); }
  bool IsRecovering();

  // Takes steps until a response for the caller is there, or an error of its request.
  std::optional<absl::StatusOr<grpc::ByteBuffer>> Advance(absl::Time deadline);
  // Opens the next call once its time has come. False: it has not by `deadline`, or ended_ is set.
  bool Open(absl::Time deadline);
  void WriteMore();
  // Returns the response if it is for the caller.
  std::optional<absl::StatusOr<grpc::ByteBuffer>> OnResponse();
  absl::Status OnStarted();
  void OnSaved(const procgen::v1::States& states, int64_t number);
  // The call is over. Returns the error if it is that of the oldest unanswered request.
  std::optional<absl::Status> OnEnd();
  void ForgetCall();
  void TakeCheckpointIfDue();
  void DropUpTo(int64_t number);
  // Whether the wait of a caller is over. Ends the call instead if it is too late for options_.
  bool IsOver(absl::Time deadline);
  // Sets ended_ if Cancel was called.
  bool IsCancelled();

  procgen::v1::StartPool start_;  // level_sampler: of the checkpoint
  const RecoveryOptions options_;
  const OpenRunStream open_;
  const RunClock clock_;
  absl::Status ended_;
  std::atomic<bool> cancelled_ = false;
  std::optional<procgen::v1::Started> started_;
  int64_t call_count_ = 0;

  std::vector<procgen::v1::State> checkpoint_;  // empty: the pool's first state
  std::vector<procgen::v1::State> saved_;       // of the next checkpoint, so far
  absl::Time checkpoint_time_;
  int64_t checkpoint_count_ = 0;
  int32_t states_per_request_ = 0;
  int64_t checkpoint_end_ = -1;  // number of the last request of the next checkpoint; -1: none
  std::deque<Entry> log_;
  int64_t log_begin_ = 0;  // number of the first request in log_
  int64_t log_bytes_ = 0;
  int64_t unanswered_count_ = 0;  // of the caller

  // The current call.
  std::mutex stream_mutex_;                            // for Cancel
  std::unique_ptr<RunStream> stream_;                  // null: none
  std::vector<procgen::v1::RunPoolRequest> prologue_;  // makes the checkpoint again
  size_t prologue_written_ = 0;
  int64_t next_write_ = 0;         // number of the next request
  std::deque<int64_t> in_flight_;  // numbers of written requests; negative: of the prologue
  bool is_writing_ = false;
  bool is_created_ = false;   // the server has answered with started
  int attempt_ = 0;           // as in OpenRunStream
  absl::Time attempt_begin_;  // of the current call

  // After a broken connection.
  std::optional<absl::Time> lost_time_;
  absl::Time next_open_time_ = absl::InfinitePast();
  absl::Duration backoff_;
  absl::Status lost_status_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_RUN_RECOVERING_STREAM_H_
