#ifndef SERVER_SESSION_POOL_REQUEST_EXECUTOR_H_
#define SERVER_SESSION_POOL_REQUEST_EXECUTOR_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "server/metrics/metrics.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/backend/request.h"
#include "server/session/pool/answer_cache.h"
#include "server/session/pool/pool_observers.h"
#include "server/session/pool/request_times.h"
#include "server/session/pool/response_sink.h"
#include "server/session/pool/resume_buffer.h"
#include "server/session/pool/turn_queue.h"

namespace procgen {

// Executes requests on a pool, each in a turn: validates it, executes it part by part into memory
// of its sink, passes each part to the observers, and keeps the answer.
//
// Threads: one request at a time, which turns ensure; const methods from any thread.
class RequestExecutor {
 public:
  // Dependencies, which must outlive this. `pool_name`: for errors.
  struct Context {
    std::string pool_name;
    PoolBackend* backend = nullptr;
    TurnQueue* turns = nullptr;
    ResumeBuffer* resume_buffer = nullptr;
    PoolObservers* observers = nullptr;
    Metrics* metrics = nullptr;
  };

  explicit RequestExecutor(Context context);

  // As the methods of PoolSession.
  void Execute(Request* request, std::shared_ptr<ResponseSink> sink);
  void ExecuteInTurn(Request* request, std::shared_ptr<ResponseSink> sink);
  void Resume() { Advance(); }

  // The number of the next new request.
  const std::atomic<int64_t>& next_sequence_number() const { return next_sequence_number_; }
  void ResumeAt(int64_t next_sequence_number) { next_sequence_number_ = next_sequence_number; }
  RequestTimes::Summary request_times() const { return request_times_.Read(); }

 private:
  // The next action of the request under way.
  enum class State : uint8_t {
    kBegin,    // it has a turn: validate it, or recall its answer
    kPrepare,  // ask the sink for memory for part_
    kRunning,  // the backend executes part_
    kPartRan,  // part_ ended with part_status_
  };

  // Takes as many steps of the request as possible now. An event on any thread meanwhile is handled
  // by the loop that already runs, so the stack does not grow with the number of parts.
  void Advance();
  // Takes one step. Returns false when the request and its turn have ended; members must not be
  // used after that.
  bool Step();
  bool Begin();
  bool Prepare();
  void RunPart();
  bool EndPart();
  bool End(const absl::Status& status);

  // Validates a new request and takes its number. Returns an answer if the request was executed
  // before. Errors, which take no number: INVALID_ARGUMENT; FAILED_PRECONDITION the answer is not
  // kept, an environment must be reset, or no shared-memory batch is free.
  absl::StatusOr<std::optional<Answer>> Accept(Request* request);
  absl::Status CheckNoneAwaitsReset(const Request& request) const;
  // Sets part_ to the range after it, with all remaining environments.
  void SelectNextPart();

  const Context context_;
  std::atomic<int64_t> next_sequence_number_ = 1;  // written in a turn
  RequestTimes request_times_;                     // likewise

  std::atomic<int> advances_due_ = 0;
  // Used only by the thread that advances. Memory is reused from turn to turn.
  State state_ = State::kBegin;
  Request* request_ = nullptr;
  std::shared_ptr<ResponseSink> sink_;
  bool of_stream_ = false;  // a stream's next request, in a turn of its own
  bool keeps_ = false;      // the answer is kept
  Answer answer_;           // the responses so far
  absl::Time begin_time_;
  absl::Time arrival_time_;  // a copy from the request, as is its number: both outlive it
  int64_t sequence_number_ = 0;
  Part part_;               // the next part, or the one that runs
  int32_t rest_ = 0;        // environments from part_ on, inclusive
  int32_t parts_left_ = 0;  // after part_
  absl::Status part_status_;
  StepInput input_;                          // for part_
  Batch batch_;                              // memory for part_
  std::vector<NextLevel> part_next_levels_;  // for part_
  std::vector<Reset> part_resets_;           // for part_
  std::vector<FinalScene> final_scenes_;     // for part_: those that observers need
  BatchNumbers unasked_;  // arrays that observers need and the learner did not request
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_REQUEST_EXECUTOR_H_
