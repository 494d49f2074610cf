#include "server/rpc/step_pool_reactor.h"

#include <cstdint>
#include <optional>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "grpcpp/server_context.h"
#include "server/rpc/convert_shared.h"
#include "server/rpc/drain_trailer.h"
#include "server/rpc/grpc_deadline.h"
#include "server/rpc/method_name.h"
#include "server/rpc/parse_message.h"
#include "server/session/event_log.h"

namespace procgen {

StepPoolReactor* StepPoolReactor::Start(Sessions* sessions, const Callers* callers,
                                        DirectLines* direct_lines,
                                        grpc::CallbackServerContext* context, Caller caller) {
  // Shared, because a callback of the pool may still be on its way out when gRPC has done with the
  // stream.
  std::shared_ptr<StepPoolReactor> reactor(
      new StepPoolReactor(sessions, callers, direct_lines, context, std::move(caller)));
  reactor->self_ = reactor;
  // Weak, because the alarm is the stream's and keeps what it calls.
  reactor->attach_alarm_.Set(GrpcDeadlineIn(sessions->limits().attach_timeout),
                             [weak = reactor->weak_from_this()](bool expired) {
                               const std::shared_ptr<StepPoolReactor> stream = weak.lock();
                               if (expired && stream != nullptr) {
                                 stream->OnAttachTimeout();
                               }
                             });
  reactor->Drive();
  return reactor.get();
}

StepPoolReactor::StepPoolReactor(Sessions* sessions, const Callers* callers,
                                 DirectLines* direct_lines, grpc::CallbackServerContext* context,
                                 Caller caller)
    : sessions_(sessions),
      callers_(callers),
      direct_lines_(direct_lines),
      context_(context),
      caller_(std::move(caller)) {}

// NOLINTBEGIN(misc-no-recursion): Drive enters itself once, and then has nothing to do.
void StepPoolReactor::Drive() {
  // An event that happens while this thread drives, in something that Act calls, is seen by the
  // loop that is under way. A second one inside of it would nest with each request.
  thread_local const StepPoolReactor* driven = nullptr;
  if (driven == this) {
    return;
  }
  const StepPoolReactor* const outer = std::exchange(driven, this);
  const absl::Cleanup restore = [outer] { driven = outer; };
  const std::shared_ptr<StepPoolReactor> self = shared_from_this();
  while (true) {
    Action action = Action::kWait;
    {
      absl::MutexLock lock(&mutex_);
      action = NextAction();
    }
    if (action == Action::kWait) {
      return;
    }
    Act(action);
    if (action == Action::kFinish) {
      return;
    }
  }
}

StepPoolReactor::Action StepPoolReactor::NextAction() {
  // What keeps the pool busy comes before what keeps the wire busy.
  if (finished_) {
    return Action::kWait;
  }
  if (part_waits_ && pool_is_gone_) {
    part_waits_ = false;
    return Action::kAbandon;
  }
  // Who is cancelled or taken over does not wait for the wire, which may be dead.
  if (part_waits_ && (cancelled_ || taken_over_ || responses_.has_free())) {
    part_waits_ = false;
    return Action::kRunPart;
  }
  if (turn_of_ == nullptr) {
    turn_of_ = requests_.Next();
    if (turn_of_ != nullptr) {
      return Action::kTurn;
    }
  }
  // Who carries out a request looks for the next one, near its end and then after it, so that no
  // thread is woken for it.
  if (line_input_ == LineInput::kUnknown && WantsLine()) {
    line_input_ = LineInput::kNone;
    requests_.BeginRead();
    return Action::kReadLine;
  }
  if (responses_.CanWrite()) {
    responses_.BeginWrite();
    return Action::kWrite;
  }
  if (line_input_ == LineInput::kNone && WantsLine()) {
    line_input_ = LineInput::kWatched;
    return Action::kWatchLine;
  }
  // Beside a direct line for its end only, however soon that was opened.
  if (!stream_reads_ && (line_ != nullptr || requests_.CanRead())) {
    stream_reads_ = true;
    if (line_ == nullptr) {
      requests_.BeginRead();
    }
    return Action::kRead;
  }
  const bool takes_no_turn = requests_.IsOver() && turn_of_ == nullptr;
  if (attached_ && !letting_go_ && takes_no_turn) {
    letting_go_ = true;
    return Action::kLetGo;
  }
  if (takes_no_turn && !attached_ && responses_.empty()) {
    finished_ = true;
    return Action::kFinish;
  }
  return Action::kWait;
}

void StepPoolReactor::Act(Action action) {
  switch (action) {
    case Action::kWait:
      return;
    case Action::kRead:
      StartRead(&read_bytes_);
      return;
    case Action::kReadLine:
      ReadLine();
      return;
    case Action::kWatchLine:
      WatchLine();
      return;
    case Action::kTurn:
      pool_->TakeTurn(
          [self = shared_from_this()](const absl::Status& status) { self->OnTurn(status); });
      return;
    case Action::kRunPart:
      RunPart();
      return;
    case Action::kAbandon:
      EndTurn();
      return;
    case Action::kLetGo:
      LetGo();
      return;
    case Action::kWrite:
      Write();
      return;
    case Action::kFinish:
      FinishStream();
      return;
  }
}

void StepPoolReactor::OnReadDone(bool ok) {
  StreamRequest* request = nullptr;
  bool beside_line = false;
  grpc::ByteBuffer bytes;
  {
    absl::MutexLock lock(&mutex_);
    bytes.Swap(&read_bytes_);
    beside_line = line_ != nullptr;
    stream_reads_ = beside_line;  // and then no more
    request = beside_line ? nullptr : requests_.EndRead(ok);
  }
  if (beside_line) {
    OnReadBesideLine(ok);
  }
  if (request == nullptr) {
    Drive();
    return;
  }
  request->arrival_time = SteadyNow();
  request->message_bytes = bytes.Length();
  sessions_->metrics().AddReceivedBytes(static_cast<int64_t>(bytes.Length()));
  absl::Status status = ParseMessage(bytes, &request->message);
  if (!std::exchange(attaching_, true)) {
    attach_alarm_.Cancel();
    if (status.ok()) {
      status = HoldLarge(request);
    }
    if (status.ok()) {
      Attach(request->message);
    } else {
      OnAttached(std::move(status));
    }
    return;
  }
  TakeIn(request, std::move(status));
}

void StepPoolReactor::OnAttachTimeout() {
  {
    absl::MutexLock lock(&mutex_);
    if (attached_) {
      return;
    }
    EndNowLocked(absl::DeadlineExceededError(absl::StrCat(
        "the stream has sent no attach within ",
        absl::FormatDuration(sessions_->limits().attach_timeout), ", limit attach_timeout")));
  }
  Drive();
}

void StepPoolReactor::Attach(const v1::StepPoolRequest& request) {
  AttachStream(
      sessions_, {caller_.owner, context_->peer()}, request,
      [self = shared_from_this()](StreamEnd why, const absl::Status& reason) {
        self->EndNow(why, reason);
      },
      [self = shared_from_this()](absl::StatusOr<Attachment> attachment) {
        self->OnAttached(std::move(attachment));
      });
}

void StepPoolReactor::OnAttached(absl::StatusOr<Attachment> attachment) {
  if (attachment.ok()) {
    pool_ = std::move(attachment->pool);
    pool_name_ = pool_->name();
    terms_ = attachment->terms;
    caller_.share = Owners::Share();
    if (direct_lines_ != nullptr && pool_->shared_ring() != nullptr) {
      line_key_ = direct_lines_->Expect(weak_from_this());
    }
  } else {
    EndAfterInbox(attachment.status());
  }
  {
    absl::MutexLock lock(&mutex_);
    requests_.EndTakingIn();
    attached_ = attachment.ok();
    if (attached_ && status_.ok()) {
      requests_.Grow(static_cast<size_t>(terms_.options.requests_in_flight_max));
      Response* response = responses_.Take();
      FillAttached(*pool_, terms_, &response->message);
      if (!line_key_.empty()) {
        FillDirectLine(*direct_lines_, line_key_, &response->message);
      }
      responses_.Push({response, {}, requests_.front()});
    }
  }
  Drive();
}

void StepPoolReactor::EndAfterInbox(absl::Status status) {
  absl::MutexLock lock(&mutex_);
  requests_.StopReading();
  if (status_.ok()) {
    status_ = std::move(status);
  }
}

void StepPoolReactor::EndNow(StreamEnd why, const absl::Status& status) {
  {
    absl::MutexLock lock(&mutex_);
    pool_is_gone_ = why == StreamEnd::kClosed;
    taken_over_ = why == StreamEnd::kTakenOver;
    EndNowLocked(status);
  }
  Drive();
}

void StepPoolReactor::FailLocked(const absl::Status& status) {
  // Requests behind the one at fault are forgotten, and so is what was wrong with them.
  status_ = status;
  EndNowLocked(status);
}

void StepPoolReactor::EndNowLocked(const absl::Status& status) {
  requests_.Stop();
  if (status_.ok()) {
    status_ = status;
  }
}

void StepPoolReactor::OnTurn(const absl::Status& turn) {
  StreamRequest* request = nullptr;
  bool unwanted = false;
  {
    absl::MutexLock lock(&mutex_);
    request = turn_of_;
    unwanted = cancelled_;
  }
  absl::StatusOr<std::optional<Answer>> accepted = absl::CancelledError();
  if (!turn.ok()) {
    accepted = turn;
  } else {
    if (!unwanted) {
      accepted = pool_->Accept(&request->request);
    }
    if (!accepted.ok() || accepted->has_value()) {
      pool_->EndTurn();
    }
  }
  {
    absl::MutexLock lock(&mutex_);
    absl::Status status = accepted.status();
    if (status.ok() && !accepted->has_value()) {
      running_.Begin(request);
      part_waits_ = true;
      unsent_ = false;
    } else {
      turn_of_ = nullptr;
      status = status.ok() ? AnswerAgain(request, **accepted) : status;
    }
    if (!status.ok()) {
      FailLocked(status);
    }
  }
  Drive();
}

absl::Status StepPoolReactor::AnswerAgain(StreamRequest* request, const Answer& answer) {
  absl::Status status =
      CheckKeptAnswer(request->request.sequence_number, answer, terms_.response_bytes_max);
  if (status.ok() && !cancelled_) {
    responses_.PushAnswer(answer, request);
  }
  return status;
}

Response* StepPoolReactor::TakeResponse() {
  // What cannot be sent is kept all the same if it may be asked for again.
  unsent_ = unsent_ || cancelled_ || !responses_.has_free();
  return unsent_ && !terms_.options.resumable ? nullptr : responses_.Take();
}

void StepPoolReactor::RunPart() {
  Response* response = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    response = TakeResponse();
  }
  running_.RunPart(
      pool_.get(), response,
      [self = shared_from_this()](const absl::Status& status) { self->OnPartDone(status); },
      [self = shared_from_this()] { self->ReadLineAhead(); });
}

void StepPoolReactor::OnPartDone(const absl::Status& status) {
  Outgoing outgoing = running_.EndPart(*pool_, status.ok(), terms_.options.resumable);
  const bool is_last = running_.IsOver();
  const int64_t number = running_.sequence_number();
  Answer answer = is_last ? running_.TakeAnswer() : Answer();
  if (is_last && status.ok()) {
    const absl::Duration queued = running_.queued();
    const absl::Duration ran = running_.ran();
    sessions_->metrics().AddRequest(queued, ran);
    pool_->AddRequestTime(queued + ran);
  }
  {
    absl::MutexLock lock(&mutex_);
    part_waits_ = !is_last;
    if (!status.ok()) {
      FailLocked(status);
    }
    if (status.ok() && outgoing.response != nullptr && !unsent_ && !cancelled_) {
      responses_.Push(std::move(outgoing));
    } else if (outgoing.response != nullptr) {
      responses_.GiveBack(outgoing.response);
    }
  }
  if (!answer.empty()) {
    pool_->Keep(number, std::move(answer));
  }
  if (is_last) {
    EndTurn();
  }
  Drive();
}

void StepPoolReactor::EndTurn() {
  pool_->EndTurn();
  absl::MutexLock lock(&mutex_);
  turn_of_ = nullptr;
}

void StepPoolReactor::LetGo() {
  running_.EndStream();
  pool_->Detach();
  // A learner that does not read keeps its stream, but not the pool, which may be deleted.
  pool_ = nullptr;
  absl::MutexLock lock(&mutex_);
  attached_ = false;
}

void StepPoolReactor::Write() {
  Outgoing* outgoing = nullptr;
  std::shared_ptr<DirectLine> line;
  {
    absl::MutexLock lock(&mutex_);
    outgoing = responses_.writing();
    line = line_;
  }
  if (line != nullptr) {
    OnWriteDone(WriteToLine(line.get(), *outgoing));
    return;
  }
  if (!outgoing->bytes.Valid()) {
    outgoing->bytes = Serialized(*outgoing->response);
  }
  sessions_->metrics().AddSentBytes(static_cast<int64_t>(outgoing->bytes.Length()));
  StartWrite(&outgoing->bytes);
}

void StepPoolReactor::OnWriteDone(bool ok) {
  StreamRequest* large = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    if (StreamRequest* answered = responses_.EndWrite(); answered != nullptr) {
      if (answered->message_bytes > kLargeMessageBytes) {
        large = answered;
      } else {
        requests_.Free(answered);
      }
    }
    if (line_input_ == LineInput::kNone) {
      line_input_ = LineInput::kUnknown;  // who was answered may have sent the next one meanwhile
    }
    if (!ok) {
      CancelLocked();
    }
  }
  if (large != nullptr) {
    *large = StreamRequest();  // frees its memory, outside of the lock
    absl::MutexLock lock(&mutex_);
    requests_.Free(large);
  }
  Drive();
}
// NOLINTEND(misc-no-recursion)

void StepPoolReactor::OnCancel() {
  {
    absl::MutexLock lock(&mutex_);
    CancelLocked();
  }
  Drive();
}

void StepPoolReactor::CancelLocked() {
  cancelled_ = true;
  EndNowLocked(absl::CancelledError());
  responses_.DropUnwritten();
}

void StepPoolReactor::FinishStream() {
  absl::Status status;
  bool was_attached = false;
  {
    absl::MutexLock lock(&mutex_);
    status = status_;
    was_attached = letting_go_;
    if (line_ != nullptr) {
      line_->HangUp();
    }
  }
  if (!line_key_.empty()) {
    direct_lines_->Forget(line_key_);
  }
  if (was_attached) {
    LogEvent(status.ok() ? LogLevel::kInfo : LogLevel::kWarning, "stream_ended",
             {{"pool", pool_name_},
              {"owner", caller_.owner},
              {"code", absl::StatusCodeToString(status.code())},
              {"message", std::string(status.message())}});
  }
  AddDrainTrailer(status, *sessions_, context_);
  Finish(callers_->Dismiss(MethodNameOf<v1::StepPoolRequest>(), status));
}

void StepPoolReactor::OnDone() { const std::shared_ptr<StepPoolReactor> last = std::move(self_); }

}  // namespace procgen
