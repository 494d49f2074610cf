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
// The life of a stream:
//  1. The first request is read and must attach, within Limits::attach_timeout; where another
//     stream is to be taken over, that one detaches first. Until then the stream is one of its
//     owner's calls under way, afterwards one of its streams.
//  2. Requests are read, one at a time, as long as the window has room (RequestWindow).
//  3. The pool executes the first of the inbox, part by part: each part is drawn straight into one
//     of two responses, so one is drawn while the other is sent. A request that was executed before
//     is answered by what was kept.
//  4. The stream detaches as soon as it will execute no further request, and ends when all is
//     written; or, after a cancellation, at once. A request that was accepted is always executed to
//     its end, if need be unsent.
//
// The learner of a pool that shares memory may open pipes: from then on requests and responses
// travel there, and gRPC's stream only shows how both sides end.
//
// All decisions are in NextAction, under the lock; each event notes what happened and calls Drive,
// which acts outside of the lock until there is nothing to do.
//
// Threads: any method from any thread. Lock order: mutex_ is held during none of the calls out.
class StepStream final : public ResponseSink,
                         public StreamTransportUser,
                         public PipeConnectionUser,
                         public std::enable_shared_from_this<StepStream> {
 public:
  struct Context {
    PoolSupervisor* supervisor = nullptr;
    const CallAccounting* accounting = nullptr;
    PipeListener* pipe_listener = nullptr;  // null: no pipes are offered
    std::string peer;                       // as gRPC names it
    StreamTransport* transport = nullptr;   // gRPC's stream; not used after `end`
    // Ends gRPC's stream; called once.
    std::function<void(const absl::Status&)> end;
  };

  StepStream(Context context, Caller caller);

  // Begins to read.
  void Start();
  // The learner has cancelled the stream, or is gone.
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
    kAttaching,  // the first one has
    kAttached,   // it has the pool
    kDetaching,  // it executes no request any more
    kDetached,   // it has let the pool go, or never had it
    kEnded,
  };
  // What ends the stream early, each stronger than those before.
  enum class Interruption : uint8_t {
    kNone,
    kTakenOver,   // another stream waits for the pool
    kCancelled,   // nobody reads the responses
    kPoolClosed,  // there is no pool any more
  };
  enum class Action : uint8_t {
    kWait,        // for an event
    kExecute,     // the next request
    kResume,      // the execution, for which a response is free now
    kWrite,       // the first of responses_
    kReadPipes,   // the next request
    kAwait,       // it, since there is nothing else to do
    kReadStream,  // the next request or, beside pipes, the end of gRPC's stream
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

  // Validates a request after the first, as far as that needs no turn.
  absl::Status Understand(StreamRequest* request) const;
  // Counts a request, if it is large, among its owner's buffers until it is answered.
  absl::Status HoldLarge(StreamRequest* request) const;
  // Reads no more; what was read before is still answered.
  void EndAfterInbox(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Reads no more and drops the inbox; what runs is executed to its end.
  void EndNow(Interruption interruption, const absl::Status& status)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Context context_;
  Caller caller_;             // its reservation: until it is attached
  grpc::Alarm attach_alarm_;  // until the first request was read
  // Set by attach; null once detached.
  std::shared_ptr<PoolSession> pool_;
  std::string pool_name_;
  StreamOptions stream_options_;
  std::string pipe_key_;                  // by which pipes may be opened; empty: none
  std::unique_ptr<PipeTransport> pipes_;  // written once, under the lock; null: none are open
  ResponseBuilder builder_;               // of the request that is executed
  Response* response_ = nullptr;          // likewise; null: its part is drawn for nobody

  absl::Mutex mutex_;
  Phase phase_ ABSL_GUARDED_BY(mutex_) = Phase::kOpen;
  Interruption interruption_ ABSL_GUARDED_BY(mutex_) = Interruption::kNone;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);  // with which the stream ends
  RequestWindow requests_ ABSL_GUARDED_BY(mutex_);
  ResponseQueue responses_ ABSL_GUARDED_BY(mutex_);
  StreamRequest* running_ ABSL_GUARDED_BY(mutex_) = nullptr;  // the request that is executed
  bool part_waits_ ABSL_GUARDED_BY(mutex_) = false;           // of running_, for a response
  bool unsent_ ABSL_GUARDED_BY(mutex_) = false;               // the rest of its answer is not sent
  bool read_waits_ ABSL_GUARDED_BY(mutex_) = false;           // for kAwait
  bool grpc_reads_ ABSL_GUARDED_BY(mutex_) = false;           // or has read beside the pipes
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_STEP_STREAM_H_
