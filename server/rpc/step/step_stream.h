#ifndef SERVER_RPC_STEP_STEP_STREAM_H_
#define SERVER_RPC_STEP_STEP_STREAM_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/alarm.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/step/attach.h"
#include "server/rpc/step/pipe_transport.h"
#include "server/rpc/step/request_window.h"
#include "server/rpc/step/response_builder.h"
#include "server/rpc/step/response_queue.h"
#include "server/rpc/step/stream_transport.h"
#include "server/session/pool/pool_session.h"
#include "server/session/pool_supervisor.h"
#include "server/shared_memory/pipe_connection.h"
#include "server/shared_memory/pipe_listener.h"
#include "server/wire/convert_step.h"

namespace procgen {

// One stream of StepPool, between a transport and a PoolSession.
//
// Life of a stream:
//  1. The first request must arrive within Limits::attach_timeout and attach. If it takes over
//     another stream, that one detaches first. Until then the stream counts as one of its owner's
//     calls, afterwards as one of its streams.
//  2. Requests are read one at a time while the RequestWindow has a free slot.
//  3. The pool executes the first request of the inbox, part by part. Each part is drawn directly
//     into one of two responses, while the other is sent. A request that was executed before gets
//     its kept answer.
//  4. The stream detaches when it will execute no further request, and ends when all responses are
//     written. A cancelled stream ends without writing. An accepted request is always executed to
//     its end, even if its answer is not sent.
//
// The learner of a pool that shares memory may open pipes. From then on requests and responses use
// the pipes, and the gRPC stream only signals the end of either side.
//
// All decisions are in NextAction, under the lock. Each event records what happened and calls
// Drive, which acts outside of the lock until there is nothing to do.
//
// Threads: any method from any thread. Lock order: mutex_ is not held during calls to other
// objects.
class StepStream final : public ResponseSink,
                         public StreamTransportUser,
                         public PipeConnectionUser,
                         public std::enable_shared_from_this<StepStream> {
 public:
  struct Context {
    PoolSupervisor* supervisor = nullptr;
    const CallAccounting* accounting = nullptr;
    PipeListener* pipe_listener = nullptr;  // null: pipes are not offered
    std::string peer;                       // address in gRPC's form
    StreamTransport* transport = nullptr;   // gRPC's stream; not used after `end`
    // Ends gRPC's stream; called once.
    std::function<void(const absl::Status&)> end;
  };

  StepStream(Context context, Caller caller);

  // Starts the first read.
  void Start();
  // The learner has cancelled the stream or disconnected.
  void OnCancel();

  void OnRead(StreamTransport* transport, const absl::Status& status) override;
  void OnWritten(bool ok) override;
  void OnPipesOpened(std::shared_ptr<PipeConnection> connection) override;
  void OnPipesInput() override { pipes_->OnInput(); }

  bool IsWanted() override;
  absl::StatusOr<std::optional<Batch>> PreparePart(Part part) override;
  void Flush() override { Drive(); }
  absl::Cord PartDone(Part part, bool keep) override;
  absl::Status Recall(const Answer& answer) override;
  void Done(const absl::Status& status) override;

 private:
  enum class Phase : uint8_t {
    kOpen,       // no request has arrived
    kAttaching,  // the first request has arrived
    kAttached,
    kDetaching,  // no further request is executed
    kDetached,   // from the pool, or attaching failed
    kEnded,
  };
  // What ends the stream early, in ascending priority.
  enum class Interruption : uint8_t {
    kNone,
    kTakenOver,  // another stream waits for the pool
    kCancelled,  // the learner has cancelled or disconnected
    kPoolClosed,
  };
  enum class Action : uint8_t {
    kWait,        // for an event
    kExecute,     // the next request
    kResume,      // the execution, because a response is free
    kWrite,       // the first of responses_
    kReadPipes,   // the next request, from the pipes
    kAwait,       // the request of a read from the pipes, because there is nothing else to do
    kReadStream,  // the next request or, with pipes open, the end of the gRPC stream
    kDetach,      // from the pool
    kEnd,         // the stream
  };

  void Drive();
  Action NextAction() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Act(Action action);

  void Write();
  void Detach();
  void End();

  void OnAttachTimeout();
  void Attach(StreamRequest* request, absl::Status status);
  void OnAttached(absl::StatusOr<Attachment> attachment);
  void OnStreamEnd(StreamEnd why, const absl::Status& reason);

  // Validates a request after the first, as far as possible without a turn.
  absl::Status Validate(StreamRequest* request) const;
  // Reserves the memory of a large request in its owner's quota, until it is answered.
  absl::Status ReserveLarge(StreamRequest* request) const;
  // Stops reading. Requests that were read before are still answered.
  void EndAfterInbox(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Stops reading and drops the inbox. The running request is executed to its end.
  void EndNow(Interruption interruption, const absl::Status& status)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Context context_;
  Caller caller_;             // has a reservation until the stream is attached
  grpc::Alarm attach_alarm_;  // until the first request is read
  // Set by attach; null once detached. Written with the lock held; OnCancel reads it at any time.
  std::shared_ptr<PoolSession> pool_;
  std::string pool_name_;
  StreamOptions stream_options_;
  std::string pipe_key_;                  // authenticates the learner's pipes; empty: none
  std::unique_ptr<PipeTransport> pipes_;  // written once, under the lock; null: not open
  ResponseBuilder builder_;               // of the running request
  Response* response_ = nullptr;          // of the current part; null: its values are dropped

  absl::Mutex mutex_;
  Phase phase_ ABSL_GUARDED_BY(mutex_) = Phase::kOpen;
  Interruption interruption_ ABSL_GUARDED_BY(mutex_) = Interruption::kNone;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);  // with which the stream ends
  RequestWindow requests_ ABSL_GUARDED_BY(mutex_);
  ResponseQueue responses_ ABSL_GUARDED_BY(mutex_);
  StreamRequest* running_ ABSL_GUARDED_BY(mutex_) = nullptr;  // the request being executed
  bool part_waits_ ABSL_GUARDED_BY(mutex_) = false;  // part of running_ waits for a free response
  bool unsent_ ABSL_GUARDED_BY(mutex_) = false;      // the rest of its answer is not sent
  bool read_waits_ ABSL_GUARDED_BY(mutex_) = false;  // a read from the pipes waits for kAwait
  // A read of the gRPC stream is in progress, or was the last one because pipes are open.
  bool grpc_reads_ ABSL_GUARDED_BY(mutex_) = false;
  // Reads of the gRPC stream that threads are about to start. Until they have, the stream must not
  // end, because gRPC frees a call that has ended.
  int starting_read_count_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_STEP_STREAM_H_
