#ifndef SERVER_RPC_STEP_POOL_REACTOR_H_
#define SERVER_RPC_STEP_POOL_REACTOR_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/alarm.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "procgen/v1/step.pb.h"
#include "server/rpc/attach.h"
#include "server/rpc/caller.h"
#include "server/rpc/convert_step.h"
#include "server/rpc/request_window.h"
#include "server/rpc/response_queue.h"
#include "server/rpc/running_request.h"
#include "server/session/pool_session.h"
#include "server/session/sessions.h"
#include "server/shared_memory/direct_line.h"
#include "server/shared_memory/direct_lines.h"

namespace procgen {

// One stream of StepPool, between gRPC's reactions and a PoolSession's turns.
//
// The life of a stream:
//  1. The first request is read and must attach, within Limits::attach_timeout; where another
//  stream
//     is to be taken over, that one lets go of the pool first. Until then the stream is one of its
//     owner's calls under way, afterwards one of its streams.
//  2. Requests are read, one at a time, as long as the window has room (RequestWindow).
//  3. The first of the inbox takes a turn at the pool, is accepted, and is carried out part by
//     part: each part is stepped straight into one of two responses, so one is stepped
//     while the other is on its way. The answers of a resumable stream are also kept by the pool.
//     A request that was carried out before is answered by what was kept.
//  4. The stream lets go of the pool as soon as it will take no further turn, and ends when all is
//     written; or, after a cancellation, at once. A request that was accepted is always carried out
//     to its end, if need be unsent: it is taken whole or not at all.
//
// The learner of a pool that shares memory may open a direct line: from then on requests come by it
// and responses go by it, and gRPC's stream only tells how both sides end.
//
// All decisions are in NextAction, under the lock; each event notes what happened and calls Drive,
// which acts outside of the lock until there is nothing to do.
//
// Threads: gRPC's reactions and the pool's callbacks come from any thread, at the same time.
// Lock order: mutex_ is held by none of the calls out.
class StepPoolReactor final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                              public DirectLineUser,
                              public std::enable_shared_from_this<StepPoolReactor> {
 public:
  // Begins to serve a stream; it ends itself. `direct_lines`: null: none is offered. What is
  // pointed to must outlive it.
  static StepPoolReactor* Start(Sessions* sessions, const Callers* callers,
                                DirectLines* direct_lines, grpc::CallbackServerContext* context,
                                Caller caller);

 private:
  enum class Action {
    kWait,       // for an event
    kRead,       // the next request
    kReadLine,   // the next request, from the direct line
    kWatchLine,  // have it tell when there is one
    kTurn,       // take a turn for turn_of_
    kRunPart,    // carry out the next part of running_
    kAbandon,    // end the turn, for the pool is gone
    kLetGo,      // detach from the pool
    kWrite,      // the first of responses_
    kFinish,     // end the stream
  };

  // What there is to be received from the direct line.
  enum class LineInput : uint8_t {
    kUnknown,  // to be looked for
    kNone,     // as far as is known
    kWatched,  // none; the line tells when there is
  };

  StepPoolReactor(Sessions* sessions, const Callers* callers, DirectLines* direct_lines,
                  grpc::CallbackServerContext* context, Caller caller);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;
  void OnLineOpened(std::shared_ptr<DirectLine> line) override;
  void OnLineInput() override;

  void Drive();
  Action NextAction() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Act(Action action);

  // What gRPC has read while requests come by the direct line.
  void OnReadBesideLine(bool ok);
  // Whether what comes by the direct line would be carried out at once.
  bool WantsLine() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ReadLine();
  // Takes in the next request while one is carried out, if it has come.
  void ReadLineAhead();
  // Takes in what was received from the line, if it is a request.
  using LineMessage = absl::StatusOr<std::optional<absl::string_view>>;
  void TakeInFromLine(const LineMessage& message);
  // Receives what a learner that has been answered sends next, if that comes soon.
  LineMessage LookForNext(DirectLine* line);
  void WatchLine();
  // Takes in what was read into `request`, by gRPC or the direct line; `status`: of its parsing.
  void TakeIn(StreamRequest* request, absl::Status status);
  void OnAttachTimeout();
  void Attach(const v1::StepPoolRequest& request);
  void OnAttached(absl::StatusOr<Attachment> attachment);
  // Counts a request, if it is large, among its owner's buffers until it is answered.
  absl::Status HoldLarge(StreamRequest* request) const;
  // Takes in a request after the first: fills in what follows from its message.
  absl::Status Understand(StreamRequest* request) const;
  // Reads no more; what was read before is still answered.
  void EndAfterInbox(absl::Status status);
  // Reads no more and forgets the inbox; what runs is carried out.
  void EndNow(StreamEnd why, const absl::Status& status);
  void EndNowLocked(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // As EndNow, because the request that runs failed.
  void FailLocked(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CancelLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  void OnTurn(const absl::Status& turn);
  // Answers a request that was carried out before. Errors: RESOURCE_EXHAUSTED a response is larger
  // than this stream takes.
  absl::Status AnswerAgain(StreamRequest* request, const Answer& answer)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // A response for the next part; null: it is carried out for nobody.
  Response* TakeResponse() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RunPart();
  void OnPartDone(const absl::Status& status);
  void EndTurn();
  void LetGo();
  void Write();
  bool WriteToLine(DirectLine* line, const Outgoing& outgoing);
  void FinishStream();

  Sessions* const sessions_;
  const Callers* const callers_;
  DirectLines* const direct_lines_;
  grpc::CallbackServerContext* const context_;
  Caller caller_;                          // its share: until it is attached
  grpc::Alarm attach_alarm_;               // until the first request was read
  std::shared_ptr<StepPoolReactor> self_;  // until OnDone
  // Set by attach; the pool is let go when no turn is taken any more.
  std::shared_ptr<PoolSession> pool_;
  std::string pool_name_;
  StreamTerms terms_;
  bool attaching_ = false;       // the first request was read
  grpc::ByteBuffer read_bytes_;  // of the read under way
  RunningRequest running_;       // of the turn that this stream has
  std::string line_key_;         // by which a direct line may be opened; empty: none
  int not_looked_for_ = 0;       // requests that are not looked for; of who reads the line
  std::string line_bytes_;       // of a message that is sent there; its memory is kept

  absl::Mutex mutex_;
  RequestWindow requests_ ABSL_GUARDED_BY(mutex_);
  ResponseQueue responses_ ABSL_GUARDED_BY(mutex_);

  StreamRequest* turn_of_ ABSL_GUARDED_BY(mutex_) = nullptr;  // for which a turn is asked or had
  bool part_waits_ ABSL_GUARDED_BY(mutex_) = false;           // of running_, for a response

  std::shared_ptr<DirectLine> line_ ABSL_GUARDED_BY(mutex_);  // null: gRPC bears the messages
  bool stream_reads_ ABSL_GUARDED_BY(mutex_) = false;  // gRPC; or it has read beside the line
  LineInput line_input_ ABSL_GUARDED_BY(mutex_) = LineInput::kUnknown;
  bool attached_ ABSL_GUARDED_BY(mutex_) = false;
  bool letting_go_ ABSL_GUARDED_BY(mutex_) = false;
  bool pool_is_gone_ ABSL_GUARDED_BY(mutex_) = false;
  bool taken_over_ ABSL_GUARDED_BY(mutex_) = false;  // somebody waits for the pool
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool unsent_ ABSL_GUARDED_BY(mutex_) = false;  // the rest of the answer is not sent
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);  // with which the stream ends
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_POOL_REACTOR_H_
