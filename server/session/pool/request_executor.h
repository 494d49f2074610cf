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
#include "server/session/pool/kept_answers.h"
#include "server/session/pool/pool_observers.h"
#include "server/session/pool/request_times.h"
#include "server/session/pool/response_sink.h"
#include "server/session/pool/resume_buffer.h"
#include "server/session/pool/turn_queue.h"

namespace procgen {

// Executes requests on a pool, each in a turn: validates it, has the environments carry it out part
// by part into memory of its sink, shows each part to the observers, and keeps the answer.
//
// Threads: one request at a time, which the turns see to; what is const from any thread.
class RequestExecutor {
 public:
  // All of it must outlive this. `pool_name`: for errors.
  struct Context {
    std::string pool_name;
    PoolBackend* backend = nullptr;
    TurnQueue* turns = nullptr;
    ResumeBuffer* resume_buffer = nullptr;
    PoolObservers* observers = nullptr;
    Metrics* metrics = nullptr;
  };

  explicit RequestExecutor(Context context);

  // As those of PoolSession.
  void Execute(Request* request, std::shared_ptr<ResponseSink> sink);
  void ExecuteInTurn(Request* request, std::shared_ptr<ResponseSink> sink);
  void Resume() { Advance(); }

  // The number that the next new request must have.
  const std::atomic<int64_t>& next_sequence_number() const { return next_sequence_number_; }
  void ResumeAt(int64_t next_sequence_number) { next_sequence_number_ = next_sequence_number; }
  RequestTimes::Summary request_times() const { return request_times_.Read(); }

 private:
  // What comes next for the request under way.
  enum class State : uint8_t {
    kBegin,    // it has a turn: validate it, or recall its answer
    kPrepare,  // ask the sink for memory for part_
    kRunning,  // the backend executes part_
    kPartRan,  // part_ ended with part_status_
  };

  // Takes as many steps of the request as can be taken now. An event that happens meanwhile, on
  // this thread or another, is seen by the loop that is under way, so that the stack does not grow
  // with the parts.
  void Advance();
  // Takes one step; false: the request and its turn have ended, and nothing here is touched more.
  bool Step();
  bool Begin();
  bool Prepare();
  void RunPart();
  bool EndPart();
  bool End(const absl::Status& status);

  // Validates a new request, and takes its number. An answer: it was executed before. Errors, which
  // take nothing: INVALID_ARGUMENT; FAILED_PRECONDITION an answer that is not kept, an environment
  // that must be reset, or no batch of shared memory that is free.
  absl::StatusOr<std::optional<Answer>> Accept(Request* request);
  absl::Status CheckNoneAwaitsReset(const Request& request) const;
  // The range after part_, as large as all that are left.
  void SelectNextPart();

  const Context context_;
  std::atomic<int64_t> next_sequence_number_ = 1;  // written in a turn
  RequestTimes request_times_;                     // likewise

  std::atomic<int> advances_due_ = 0;
  // Of who advances; memory is kept from turn to turn.
  State state_ = State::kBegin;
  Request* request_ = nullptr;
  std::shared_ptr<ResponseSink> sink_;
  bool of_stream_ = false;  // it is the next of a stream, in a turn of its own
  bool keeps_ = false;      // its answer
  Answer answer_;           // as far as it goes
  absl::Time begin_time_;
  absl::Time arrival_time_;  // of the request, as is its number: both outlive it
  int64_t sequence_number_ = 0;
  Part part_;               // the next, or that which runs
  int32_t rest_ = 0;        // environments from part_ on
  int32_t parts_left_ = 0;  // after part_
  absl::Status part_status_;
  StepInput input_;                          // of part_
  Batch batch_;                              // where it is written
  std::vector<NextLevel> part_next_levels_;  // those of part_
  std::vector<Reset> part_resets_;           // those of part_
  BatchNumbers unasked_;  // what is read of a batch here and its learner has not asked for
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_REQUEST_EXECUTOR_H_
