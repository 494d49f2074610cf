#ifndef SERVER_RPC_RUN_RUN_POOL_REACTOR_H_
#define SERVER_RPC_RUN_RUN_POOL_REACTOR_H_

#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "procgen/v1/run.pb.h"
#include "server/pool/pool_supervisor.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/run/pool_run.h"

namespace procgen {

// The gRPC stream of RunPool: reads requests ahead, passes them to a PoolRun one at a time, and
// sends the responses in order. One response is drawn while another is sent.
//
// Every event updates the members and calls Drive, in which one thread at a time takes all actions
// that are due. The stream ends when no request is being executed and nothing is left to send.
// Threads: gRPC's and the pool's.
class RunPoolReactor final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                             public std::enable_shared_from_this<RunPoolReactor> {
 public:
  // Starts to serve a stream. The pointers must outlive it.
  static RunPoolReactor* Start(PoolSupervisor* supervisor, const CallAccounting* accounting,
                               grpc::CallbackServerContext* context, Caller caller);

 private:
  struct Received {
    v1::RunPoolRequest message;
    size_t bytes = 0;  // of the serialised message
    absl::Time arrival_time;
  };
  enum class Action { kNone, kRead, kExecute, kWrite, kFinish };

  RunPoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting,
                 grpc::CallbackServerContext* context, Caller caller);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void Drive();
  Action NextAction() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Act(Action action);
  void Execute();
  void OnResponse(absl::StatusOr<grpc::ByteBuffer> response);
  void Finish();
  // Ends the stream with `status` after the responses so far; drops the requests that wait.
  void End(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  grpc::CallbackServerContext* const context_;
  // Keeps this alive while callbacks of the pool run. Reset by OnDone.
  std::shared_ptr<RunPoolReactor> self_;
  std::shared_ptr<PoolRun> run_;
  grpc::ByteBuffer read_bytes_;   // of the read in progress
  grpc::ByteBuffer write_bytes_;  // of the write in progress

  absl::Mutex mutex_;
  Caller caller_ ABSL_GUARDED_BY(mutex_);
  bool is_driving_ ABSL_GUARDED_BY(mutex_) = false;  // a thread is in Drive
  bool is_reading_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_executing_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_half_closed_ ABSL_GUARDED_BY(mutex_) = false;  // no further request will arrive
  bool has_pool_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_ending_ ABSL_GUARDED_BY(mutex_) = false;     // no further request is executed
  bool is_cancelled_ ABSL_GUARDED_BY(mutex_) = false;  // nothing more is sent
  bool is_finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status last_read_ ABSL_GUARDED_BY(mutex_);  // an error: garbage instead of a request
  absl::Status status_ ABSL_GUARDED_BY(mutex_);     // of End, with which the stream ends
  std::deque<std::unique_ptr<Received>> inbox_ ABSL_GUARDED_BY(mutex_);
  size_t inbox_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // of the requests in inbox_
  std::vector<std::unique_ptr<Received>> free_ ABSL_GUARDED_BY(mutex_);  // to be used again
  std::unique_ptr<Received> executing_ ABSL_GUARDED_BY(mutex_);
  std::deque<grpc::ByteBuffer> outbox_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_RPC_RUN_RUN_POOL_REACTOR_H_
