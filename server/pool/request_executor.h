#ifndef SERVER_POOL_REQUEST_EXECUTOR_H_
#define SERVER_POOL_REQUEST_EXECUTOR_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "server/concurrency/background_executor.h"
#include "server/metrics/metrics.h"
#include "server/pool/pool_observers.h"
#include "server/pool/request.h"
#include "server/pool/request_times.h"
#include "server/pool/response_sink.h"
#include "server/pool/turn_queue.h"

namespace procgen {

// Executes the requests of a pool's stream, each in a turn: validates it, lets the engine write
// into memory of its sink, and shows the batch to the observers.
//
// Threads: one request at a time; const methods from any thread.
class RequestExecutor {
 public:
  // Dependencies, which must outlive this. `owner`, `pool_name`: of the pool.
  struct Context {
    std::string owner;
    std::string pool_name;
    Pool* pool = nullptr;
    BackgroundExecutor* executor = nullptr;
    TurnQueue* turns = nullptr;
    PoolObservers* observers = nullptr;
    Metrics* metrics = nullptr;
  };

  explicit RequestExecutor(Context context);

  // As PoolSession::Execute, without its pause.
  void Execute(Request* request, std::shared_ptr<ResponseSink> sink);

  // Requests executed so far.
  int64_t request_count() const { return request_count_; }
  RequestTimes::Summary request_times() const { return request_times_.Read(); }

 private:
  void Begin();
  absl::Status CheckNoneAwaitsReset() const;
  void Step();
  void OnExecuted(const absl::Status& status);
  // Ends the turn and the request.
  void End(const absl::Status& status);

  const Context context_;
  std::atomic<int64_t> request_count_ = 0;  // written in a turn
  RequestTimes request_times_;              // likewise

  // Of the request being executed. Memory is reused from one to the next.
  Request* request_ = nullptr;
  std::shared_ptr<ResponseSink> sink_;
  absl::Time begin_time_;
  StepInput input_;
  Batch batch_;
  std::vector<FinalScene> final_scenes_;  // those that observers need
  BatchNumbers unasked_;  // arrays that observers need and the learner did not request
};

}  // namespace procgen

#endif  // SERVER_POOL_REQUEST_EXECUTOR_H_
