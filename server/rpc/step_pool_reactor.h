#ifndef SERVER_RPC_STEP_POOL_REACTOR_H_
#define SERVER_RPC_STEP_POOL_REACTOR_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/alarm.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "procgen/v1/step.pb.h"
#include "server/rpc/caller.h"
#include "server/rpc/convert_step.h"
#include "server/session/pool_session.h"
#include "server/session/sessions.h"

namespace procgen {

// One stream of StepPool, between gRPC's reactions and a PoolSession's turns.
//
// The life of a stream:
//  1. The first request is read and must attach, within Limits::attach_timeout. Until then the
//  stream
//     is one of its owner's calls under way, afterwards one of its streams.
//  2. Requests are read, one at a time, as long as one of requests_in_flight_max slots is free;
//     they wait in `inbox_`. A slot is free again when its last response is written: a learner that
//     does not read its answers is not read either.
//  3. The first of the inbox takes a turn at the pool, is accepted, and is carried out part by
//     part: each part is stepped straight into one of two response messages, so one is stepped
//     while the other is on its way.
//  4. The stream ends when no more is read, the inbox is empty, no turn is held and all is written;
//     or, after a cancellation, as soon as the turn has ended. A request that was accepted is
//     always carried out to its end, if need be unseen: it is taken whole or not at all.
//
// All decisions are in NextAction, under the lock; each event notes what happened and calls Drive,
// which acts outside of the lock until there is nothing to do.
//
// Threads: gRPC's reactions and the pool's callbacks come from any thread, at the same time.
// Lock order: mutex_ is held by none of the calls out.
class StepPoolReactor final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                              public std::enable_shared_from_this<StepPoolReactor> {
 public:
  // Begins to serve a stream; it ends itself. `sessions` must outlive it.
  static StepPoolReactor* Start(Sessions* sessions, Caller caller);

 private:
  struct Response {
    v1::StepPoolResponse message;
    grpc::ByteBuffer bytes;
    StreamRequest* answered = nullptr;  // the request of which this is the last response
  };

  enum class Action {
    kWait,     // for an event
    kRead,     // the next request into reading_
    kTurn,     // take a turn for running_
    kRunPart,  // carry out the next part of running_
    kAbandon,  // end the turn of running_, whose pool is gone
    kWrite,    // the first of written_
    kFinish,   // end the stream
  };

  StepPoolReactor(Sessions* sessions, Caller caller);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void Drive();
  Action NextAction() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Act(Action action);

  void OnAttachTimeout();
  void OnRequest(StreamRequest* request);
  // Fills in what follows from the message of a request after the first.
  absl::Status Understand(StreamRequest* request) const;
  absl::Status Attach(const v1::Attach& attach);
  // Reads no more; what was read before is still answered.
  void EndAfterInbox(absl::Status status);
  // Reads no more and forgets the inbox; what runs is carried out.
  void EndNow(const absl::Status& status, bool pool_is_gone);
  void EndNowLocked(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // As EndNow, because the request that runs failed.
  void FailLocked(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CancelLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  void OnTurn(const absl::Status& status);
  void RunPart();
  void OnPartDone(absl::Status status);
  void EndTurn();
  void Write();
  void FinishStream();

  Sessions* const sessions_;
  Caller caller_;                          // its share: until it is attached
  grpc::Alarm attach_alarm_;               // until then, too
  std::shared_ptr<StepPoolReactor> self_;  // until OnDone
  std::shared_ptr<PoolSession> pool_;      // set before attached_
  int64_t response_bytes_max_ = 0;

  absl::Mutex mutex_;
  std::vector<std::unique_ptr<StreamRequest>> slots_ ABSL_GUARDED_BY(mutex_);
  std::vector<StreamRequest*> free_slots_ ABSL_GUARDED_BY(mutex_);
  std::deque<StreamRequest*> inbox_ ABSL_GUARDED_BY(mutex_);
  StreamRequest* reading_ ABSL_GUARDED_BY(mutex_) = nullptr;  // what a read fills, or null
  bool taking_in_ ABSL_GUARDED_BY(mutex_) = false;            // what was read
  bool reading_ended_ ABSL_GUARDED_BY(mutex_) = false;

  StreamRequest* running_ ABSL_GUARDED_BY(mutex_) = nullptr;  // of which the turn is, or null
  bool part_waits_ ABSL_GUARDED_BY(mutex_) = false;           // to be carried out, for a response
  bool pool_is_gone_ ABSL_GUARDED_BY(mutex_) = false;
  Part part_ ABSL_GUARDED_BY(mutex_);                          // the next, or that which runs
  Response* part_response_ ABSL_GUARDED_BY(mutex_) = nullptr;  // of that which runs; null: unseen
  std::vector<std::unique_ptr<Response>> responses_ ABSL_GUARDED_BY(mutex_);
  std::vector<Response*> free_responses_ ABSL_GUARDED_BY(mutex_);
  std::deque<Response*> written_ ABSL_GUARDED_BY(mutex_);  // to be written, in order
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;           // the first of written_

  bool attached_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);  // with which the stream ends
  grpc::ByteBuffer read_bytes_;                  // of the read under way
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_POOL_REACTOR_H_
