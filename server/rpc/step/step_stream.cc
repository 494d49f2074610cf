#include "server/rpc/step/step_stream.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/concurrency/deadline_timer.h"
#include "server/logging/event_log.h"
#include "server/rpc/call/drive_guard.h"
#include "server/rpc/grpc/grpc_deadline.h"
#include "server/wire/convert_pool.h"
#include "server/wire/convert_shared.h"

namespace procgen {

StepStream::StepStream(Context context, Caller caller)
    : context_(std::move(context)), caller_(std::move(caller)) {}

void StepStream::Start() {
  // Weak, because the stream owns the alarm, which owns its callback.
  attach_alarm_.Set(GrpcDeadlineIn(context_.supervisor->limits().attach_timeout),
                    [weak = weak_from_this()](bool expired) {
                      const std::shared_ptr<StepStream> stream = weak.lock();
                      if (expired && stream != nullptr) {
                        stream->OnAttachTimeout();
                      }
                    });
  Drive();
}

// NOLINTBEGIN(misc-no-recursion): a nested call of Drive returns immediately.
void StepStream::Drive() {
  const DriveGuard guard(this);
  if (guard.is_nested()) {
    return;
  }
  const std::shared_ptr<StepStream> self = shared_from_this();
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
  }
}

StepStream::Action StepStream::NextAction() {
  // Work for the pool comes before work for the connection.
  if (phase_ == Phase::kEnded) {
    return Action::kWait;
  }
  // An interrupted stream does not wait for the connection, which may be dead.
  if (part_waits_ && (interruption_ != Interruption::kNone || responses_.has_free())) {
    part_waits_ = false;
    return Action::kResume;
  }
  if (running_ == nullptr) {
    running_ = requests_.Next();
    if (running_ != nullptr) {
      unsent_ = false;
      return Action::kExecute;
    }
  }
  if (responses_.CanWrite()) {
    responses_.BeginWrite();
    return Action::kWrite;
  }
  // The transport of a read is chosen here, because pipes may be opened at any time.
  if (pipes_ != nullptr && requests_.CanRead()) {
    requests_.BeginRead();
    return Action::kReadPipes;
  }
  if (!grpc_reads_ && (pipes_ != nullptr || requests_.CanRead())) {
    grpc_reads_ = true;
    ++starting_read_count_;
    if (pipes_ == nullptr) {
      requests_.BeginRead();
    }
    return Action::kReadStream;
  }
  const bool is_idle = requests_.IsOver() && running_ == nullptr;
  if (read_waits_ && running_ == nullptr && !is_idle) {
    read_waits_ = false;
    return Action::kAwait;
  }
  if (is_idle && phase_ == Phase::kAttached) {
    phase_ = Phase::kDetaching;
    return Action::kDetach;
  }
  if (is_idle && phase_ != Phase::kDetaching && responses_.empty() && starting_read_count_ == 0) {
    phase_ = Phase::kEnded;
    return Action::kEnd;
  }
  return Action::kWait;
}

void StepStream::Act(Action action) {
  switch (action) {
    case Action::kWait:
      return;
    case Action::kExecute: {
      StreamRequest* request = nullptr;
      {
        absl::MutexLock lock(&mutex_);
        request = running_;
      }
      pool_->Execute(&request->request, shared_from_this());
      return;
    }
    case Action::kResume:
      pool_->Resume();
      return;
    case Action::kWrite:
      Write();
      return;
    case Action::kReadPipes:
      if (!pipes_->Read()) {
        absl::MutexLock lock(&mutex_);
        read_waits_ = true;
      }
      return;
    case Action::kAwait:
      pipes_->Await();
      return;
    case Action::kReadStream: {
      context_.transport->Read();
      absl::MutexLock lock(&mutex_);
      --starting_read_count_;
      return;
    }
    case Action::kDetach:
      Detach();
      return;
    case Action::kEnd:
      End();
      return;
  }
}

void StepStream::OnRead(StreamTransport* transport, const absl::Status& status) {
  StreamRequest* request = nullptr;
  bool is_first = false;
  {
    absl::MutexLock lock(&mutex_);
    const bool bypasses_pipes = transport == context_.transport && pipes_ != nullptr;
    if (transport == context_.transport) {
      grpc_reads_ = bypasses_pipes;  // if set, it was the last read
    }
    if (!bypasses_pipes) {
      request = requests_.EndRead(status.ok());
    }
    if (bypasses_pipes || !status.ok()) {
      EndAfterInbox(status.ok() ? absl::InvalidArgumentError("a request arrived on the gRPC stream "
                                                             "while its pipe transport is open, "
                                                             "allowed: on the pipes")
                    : absl::IsCancelled(status) ? absl::OkStatus()
                                                : status);
    }
    if (request != nullptr && phase_ == Phase::kOpen) {
      phase_ = Phase::kAttaching;
      is_first = true;
    }
  }
  if (request == nullptr) {
    Drive();
    return;
  }
  request->request.arrival_time = SteadyNow();
  absl::Status parsed = transport->Parse(request);
  if (parsed.ok()) {
    parsed = ReserveLarge(request);
  }
  if (is_first) {
    Attach(request, std::move(parsed));
    return;
  }
  if (parsed.ok()) {
    parsed = Validate(request);
  }
  {
    absl::MutexLock lock(&mutex_);
    if (!parsed.ok()) {
      EndAfterInbox(parsed);
    }
    requests_.Enqueue(request);
  }
  Drive();
}

absl::Status StepStream::ReserveLarge(StreamRequest* request) const {
  if (request->message_bytes <= kLargeMessageBytes) {
    return absl::OkStatus();
  }
  absl::StatusOr<Quotas::Reservation> reservation = context_.accounting->ReserveBytes(
      caller_.owner, static_cast<int64_t>(request->message.SpaceUsedLong()));
  if (!reservation.ok()) {
    return reservation.status();
  }
  request->reservation = *std::move(reservation);
  return absl::OkStatus();
}

absl::Status StepStream::Validate(StreamRequest* request) const {
  if (absl::Status status = ReadStreamRequest(request); !status.ok()) {
    return status;
  }
  if (std::shared_ptr<const LevelSampler>& sampler = request->request.level_sampler;
      sampler != nullptr) {
    auto held = HoldSampler(caller_.owner, std::move(sampler), &context_.supervisor->quotas());
    if (!held.ok()) {
      return held.status();
    }
    sampler = *std::move(held);
  }
  if (pool_->shared_batch_slots() != nullptr) {
    request->request.chunk_count = 1;  // its response has no observations to be split
    return absl::OkStatus();
  }
  const absl::StatusOr<int32_t> rows_max =
      ResponseRowsMax("attach.response_bytes_max", request->request, pool_->coding(),
                      stream_options_.response_bytes_max);
  request->request.chunk_rows_max = rows_max.value_or(0);
  return rows_max.status();
}

void StepStream::OnAttachTimeout() {
  {
    absl::MutexLock lock(&mutex_);
    if (phase_ != Phase::kOpen) {
      return;
    }
    EndNow(Interruption::kNone,
           absl::DeadlineExceededError(
               absl::StrCat("the stream has sent no attach within ",
                            absl::FormatDuration(context_.supervisor->limits().attach_timeout),
                            ", limit attach_timeout")));
  }
  Drive();
}

void StepStream::Attach(StreamRequest* request, absl::Status status) {
  attach_alarm_.Cancel();
  if (!status.ok()) {
    OnAttached(std::move(status));
    return;
  }
  AttachStream(
      context_.supervisor, {caller_.owner, context_.peer}, request->message,
      [self = shared_from_this()](StreamEnd why, const absl::Status& reason) {
        self->OnStreamEnd(why, reason);
      },
      [self = shared_from_this()](absl::StatusOr<Attachment> attachment) {
        self->OnAttached(std::move(attachment));
      });
}

void StepStream::OnAttached(absl::StatusOr<Attachment> attachment) {
  if (attachment.ok()) {
    {
      absl::MutexLock lock(&mutex_);
      pool_ = std::move(attachment->pool);
    }
    pool_name_ = pool_->name();
    stream_options_ = attachment->stream_options;
    caller_.reservation = Quotas::Reservation();
    if (context_.pipe_listener != nullptr && pool_->shared_batch_slots() != nullptr) {
      pipe_key_ = context_.pipe_listener->Expect(weak_from_this());
    }
  }
  {
    absl::MutexLock lock(&mutex_);
    phase_ = attachment.ok() ? Phase::kAttached : Phase::kDetached;
    if (!attachment.ok()) {
      EndAfterInbox(attachment.status());
    }
    requests_.EndParse();
    if (attachment.ok() && status_.ok()) {
      requests_.Grow(static_cast<size_t>(stream_options_.attach.requests_in_flight_max));
      Response* response = responses_.Take();
      FillAttached(*pool_, stream_options_, &response->message);
      if (!pipe_key_.empty()) {
        FillPipeTransport(*context_.pipe_listener, pipe_key_, &response->message);
      }
      responses_.Push({response, {}, requests_.front()});
    }
  }
  Drive();
}

void StepStream::OnPipesOpened(std::shared_ptr<PipeConnection> connection) {
  auto pipes =
      std::make_unique<PipeTransport>(std::move(connection), this, &context_.supervisor->metrics());
  {
    absl::MutexLock lock(&mutex_);
    pipes_ = std::move(pipes);
    requests_.AbandonRead();
    if (phase_ == Phase::kEnded) {
      pipes_->HangUp();  // reported by OnPipesInput
    }
  }
  Drive();
}

void StepStream::EndAfterInbox(const absl::Status& status) {
  requests_.StopReading();
  status_.Update(status);
}

void StepStream::EndNow(Interruption interruption, const absl::Status& status) {
  interruption_ = std::max(interruption_, interruption);
  requests_.Stop();
  status_.Update(status);
  if (interruption == Interruption::kCancelled) {
    responses_.DropUnwritten();
  }
}

void StepStream::OnStreamEnd(StreamEnd why, const absl::Status& reason) {
  {
    absl::MutexLock lock(&mutex_);
    EndNow(why == StreamEnd::kClosed      ? Interruption::kPoolClosed
           : why == StreamEnd::kTakenOver ? Interruption::kTakenOver
                                          : Interruption::kNone,
           reason);
  }
  Drive();
}

void StepStream::OnCancel() {
  std::shared_ptr<PoolSession> pool;
  {
    absl::MutexLock lock(&mutex_);
    EndNow(Interruption::kCancelled, absl::CancelledError());
    pool = pool_;
  }
  if (pool != nullptr) {
    pool->OnLearnerGone();
  }
  Drive();
}

bool StepStream::IsWanted() {
  absl::MutexLock lock(&mutex_);
  return interruption_ != Interruption::kCancelled;
}

absl::StatusOr<std::optional<Batch>> StepStream::PreparePart(Part part) {
  StreamRequest* request = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    if (!responses_.has_free() && interruption_ == Interruption::kNone) {
      part_waits_ = true;
      return std::nullopt;
    }
    if (!responses_.has_free() && interruption_ == Interruption::kPoolClosed) {
      return status_;
    }
    // An answer that cannot be sent is still kept if the stream is resumable.
    unsent_ = unsent_ || interruption_ == Interruption::kCancelled || !responses_.has_free();
    if (unsent_ && !stream_options_.attach.resumable) {
      return Batch();
    }
    response_ = responses_.Take();
    request = running_;
  }
  return builder_.Prepare(*pool_, request->request, part, response_);
}

absl::Cord StepStream::PartDone(Part part, bool keep) {
  if (response_ == nullptr) {
    return {};
  }
  StreamRequest* running = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    running = running_;
  }
  const Request& request = running->request;
  Outgoing outgoing = {response_, {}, nullptr};
  absl::Cord kept = builder_.Complete(*pool_, request, keep, response_, &outgoing.bytes);
  if (part.first + part.count == request.first + request.count) {
    outgoing.answered = running;
  }
  absl::MutexLock lock(&mutex_);
  if (unsent_ || interruption_ == Interruption::kCancelled) {
    responses_.Release(response_);
  } else {
    responses_.Push(std::move(outgoing));
  }
  response_ = nullptr;
  return kept;
}

absl::Status StepStream::Recall(const Answer& answer) {
  absl::MutexLock lock(&mutex_);
  if (absl::Status status = CheckKeptAnswer(running_->request.sequence_number, answer,
                                            stream_options_.response_bytes_max);
      !status.ok()) {
    return status;
  }
  if (interruption_ != Interruption::kCancelled) {
    responses_.PushAnswer(answer, running_);
  }
  return absl::OkStatus();
}

void StepStream::Done(const absl::Status& status) {
  {
    absl::MutexLock lock(&mutex_);
    if (response_ != nullptr) {
      responses_.Release(std::exchange(response_, nullptr));
    }
    running_ = nullptr;
    if (!status.ok()) {
      // Later requests are dropped, and so are their errors.
      status_ = status;
      EndNow(Interruption::kNone, status);
    }
  }
  Drive();
}

void StepStream::Detach() {
  builder_.ResetEncoder();
  pool_->Detach();
  // A learner that does not read keeps its stream but not the pool, which may be deleted.
  std::shared_ptr<PoolSession> pool;
  absl::MutexLock lock(&mutex_);
  std::swap(pool, pool_);
  phase_ = Phase::kDetached;
}

void StepStream::Write() {
  Outgoing* outgoing = nullptr;
  StreamTransport* to = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    outgoing = responses_.writing();
    to = pipes_ != nullptr ? pipes_.get() : context_.transport;
  }
  to->Write(outgoing);
}

void StepStream::OnWritten(bool ok) {
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
    if (!ok) {
      EndNow(Interruption::kCancelled, absl::CancelledError());
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

void StepStream::End() {
  absl::Status status;
  {
    absl::MutexLock lock(&mutex_);
    status = status_;
    if (pipes_ != nullptr) {
      pipes_->HangUp();
    }
  }
  if (!pipe_key_.empty()) {
    context_.pipe_listener->Forget(pipe_key_);
  }
  if (!pool_name_.empty()) {
    LogEvent(status.ok() ? LogLevel::kInfo : LogLevel::kWarning, "stream_ended",
             {{"pool", pool_name_},
              {"owner", caller_.owner},
              {"code", absl::StatusCodeToString(status.code())},
              {"message", std::string(status.message())}});
  }
  context_.end(status);
}

}  // namespace procgen
