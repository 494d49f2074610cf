#include "server/rpc/step_pool_reactor.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/rpc/convert_pool.h"
#include "server/rpc/grpc_status.h"
#include "server/rpc/response_limit.h"
#include "server/rpc/unary_call.h"
#include "server/session/event_log.h"

namespace procgen {
namespace {

// One is stepped while the other is on its way.
constexpr int kResponseCount = 2;

absl::Status CheckAttach(const v1::Attach& attach, const Limits& limits) {
  if (attach.resumable() || attach.take_over()) {
    return absl::UnimplementedError(absl::StrCat(
        attach.resumable() ? "attach.resumable" : "attach.take_over", " is not offered yet"));
  }
  const int32_t in_flight = attach.requests_in_flight_max();
  if (in_flight > limits.requests_in_flight_max) {
    return absl::ResourceExhaustedError(absl::StrCat("attach.requests_in_flight_max is ", in_flight,
                                                     ", limit requests_in_flight_max is ",
                                                     limits.requests_in_flight_max));
  }
  if (in_flight < 0) {
    return absl::InvalidArgumentError(absl::StrCat("attach.requests_in_flight_max is ", in_flight,
                                                   ", allowed: 0 to ",
                                                   limits.requests_in_flight_max));
  }
  return absl::OkStatus();
}

}  // namespace

StepPoolReactor* StepPoolReactor::Start(Sessions* sessions, Caller caller) {
  // Shared, because a callback of the pool may still be on its way out when gRPC has done with the
  // stream.
  std::shared_ptr<StepPoolReactor> reactor(new StepPoolReactor(sessions, std::move(caller)));
  reactor->self_ = reactor;
  // Weak, because the alarm is the stream's and keeps what it calls.
  reactor->attach_alarm_.Set(absl::ToChronoTime(absl::Now() + sessions->limits().attach_timeout),
                             [weak = reactor->weak_from_this()](bool expired) {
                               const std::shared_ptr<StepPoolReactor> stream = weak.lock();
                               if (expired && stream != nullptr) {
                                 stream->OnAttachTimeout();
                               }
                             });
  reactor->Drive();
  return reactor.get();
}

StepPoolReactor::StepPoolReactor(Sessions* sessions, Caller caller)
    : sessions_(sessions), caller_(std::move(caller)) {
  absl::MutexLock lock(&mutex_);
  slots_.push_back(std::make_unique<StreamRequest>());
  free_slots_.push_back(slots_.back().get());
  for (int i = 0; i < kResponseCount; ++i) {
    responses_.push_back(std::make_unique<Response>());
    free_responses_.push_back(responses_.back().get());
  }
}

void StepPoolReactor::Drive() {
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
  if (part_waits_ && (cancelled_ || !free_responses_.empty())) {
    part_waits_ = false;
    part_response_ = nullptr;
    if (!cancelled_) {
      part_response_ = free_responses_.back();
      free_responses_.pop_back();
    }
    return Action::kRunPart;
  }
  if (running_ == nullptr && !inbox_.empty()) {
    running_ = inbox_.front();
    inbox_.pop_front();
    return Action::kTurn;
  }
  if (reading_ == nullptr && !taking_in_ && !reading_ended_ && !free_slots_.empty()) {
    reading_ = free_slots_.back();
    free_slots_.pop_back();
    return Action::kRead;
  }
  if (!written_.empty() && !writing_) {
    writing_ = true;
    return Action::kWrite;
  }
  if (reading_ended_ && !taking_in_ && inbox_.empty() && running_ == nullptr && written_.empty()) {
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
  {
    absl::MutexLock lock(&mutex_);
    request = std::exchange(reading_, nullptr);
    if (!ok || reading_ended_) {
      reading_ended_ = true;
      request = nullptr;
    }
    taking_in_ = request != nullptr;
  }
  if (request != nullptr) {
    OnRequest(request);
    absl::MutexLock lock(&mutex_);
    taking_in_ = false;
  }
  Drive();
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

void StepPoolReactor::OnRequest(StreamRequest* request) {
  absl::Status status = ParseMessage(read_bytes_, &request->message);
  read_bytes_.Clear();
  if (pool_ == nullptr) {
    if (status.ok() && !request->message.has_attach()) {
      status = absl::InvalidArgumentError(
          "the first request of a stream has no attach; name the pool there");
    }
    if (status.ok() && request->message.sequence_number() != 0) {
      status = absl::InvalidArgumentError(absl::StrCat(
          "sequence_number is ", request->message.sequence_number(), " with attach, allowed: 0"));
    }
    if (status.ok()) {
      status = Attach(request->message.attach());
    }
    if (status.ok()) {
      return;
    }
  } else if (status.ok()) {
    status = Understand(request);
  }
  if (!status.ok()) {
    EndAfterInbox(std::move(status));
    return;
  }
  absl::MutexLock lock(&mutex_);
  if (!reading_ended_) {
    inbox_.push_back(request);
  }
}

absl::Status StepPoolReactor::Understand(StreamRequest* request) const {
  if (absl::Status status = ReadStreamRequest(request); !status.ok()) {
    return status;
  }
  const absl::StatusOr<int32_t> rows_max = ResponseRowsMax(
      "attach.response_bytes_max", *request, pool_->observation_bytes(), response_bytes_max_);
  request->rows_max = rows_max.value_or(0);
  return rows_max.status();
}

absl::Status StepPoolReactor::Attach(const v1::Attach& attach) {
  const Limits& limits = sessions_->limits();
  if (absl::Status status = CheckAttach(attach, limits); !status.ok()) {
    return status;
  }
  const absl::StatusOr<int64_t> response_bytes_max =
      ResponseBytesMax("attach.response_bytes_max", attach.response_bytes_max(), limits);
  if (!response_bytes_max.ok()) {
    return response_bytes_max.status();
  }
  absl::StatusOr<std::shared_ptr<PoolSession>> pool =
      sessions_->FindForStream(caller_.owner, attach.pool());
  if (!pool.ok()) {
    return pool.status();
  }
  absl::Status status = (*pool)->Attach([self = shared_from_this()](const absl::Status& reason) {
    self->EndNow(reason, /*pool_is_gone=*/absl::IsAborted(reason));
  });
  if (!status.ok()) {
    return status;
  }
  if (sessions_->draining()) {  // it may have told all streams before this one attached
    (*pool)->Detach();
    return Sessions::Draining();
  }
  const int32_t slot_count = attach.requests_in_flight_max() == 0
                                 ? std::min(kRequestsInFlightDefault, limits.requests_in_flight_max)
                                 : attach.requests_in_flight_max();
  response_bytes_max_ = *response_bytes_max;
  pool_ = *std::move(pool);
  attach_alarm_.Cancel();
  caller_.share = Owners::Share();
  LogEvent(LogLevel::kInfo, "stream_attached",
           {{"pool", pool_->name()}, {"owner", pool_->owner()}});

  absl::MutexLock lock(&mutex_);
  attached_ = true;
  while (slots_.size() < static_cast<size_t>(slot_count)) {
    slots_.push_back(std::make_unique<StreamRequest>());
    free_slots_.push_back(slots_.back().get());
  }
  Response* response = free_responses_.back();
  free_responses_.pop_back();
  response->answered = slots_.front().get();
  response->message.set_sequence_number(0);
  v1::Attached* attached = response->message.mutable_attached();
  *attached->mutable_pool() = PoolMessageOf(*pool_);
  attached->set_next_sequence_number(pool_->next_sequence_number());
  attached->set_oldest_kept_sequence_number(pool_->next_sequence_number());
  attached->set_response_bytes_max(response_bytes_max_);
  attached->set_requests_in_flight_max(slot_count);
  written_.push_back(response);
  return absl::OkStatus();
}

void StepPoolReactor::EndAfterInbox(absl::Status status) {
  absl::MutexLock lock(&mutex_);
  reading_ended_ = true;
  if (status_.ok()) {
    status_ = std::move(status);
  }
}

void StepPoolReactor::EndNow(const absl::Status& status, bool pool_is_gone) {
  {
    absl::MutexLock lock(&mutex_);
    pool_is_gone_ = pool_is_gone;
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
  reading_ended_ = true;
  inbox_.clear();
  if (status_.ok()) {
    status_ = status;
  }
}

void StepPoolReactor::OnTurn(const absl::Status& turn) {
  StreamRequest* request = nullptr;
  bool unwanted = false;
  {
    absl::MutexLock lock(&mutex_);
    request = running_;
    unwanted = cancelled_;
  }
  absl::Status status = turn;
  if (turn.ok()) {
    status = unwanted ? absl::CancelledError() : pool_->Accept(&request->request);
    if (!status.ok()) {
      pool_->EndTurn();
    }
  }
  {
    absl::MutexLock lock(&mutex_);
    if (status.ok()) {
      part_ = {request->request.first, std::min(request->rows_max, request->request.count)};
      part_waits_ = true;
    } else {
      running_ = nullptr;
      FailLocked(status);
    }
  }
  Drive();
}

void StepPoolReactor::RunPart() {
  StreamRequest* request = nullptr;
  Response* response = nullptr;
  Part part;
  {
    absl::MutexLock lock(&mutex_);
    request = running_;
    response = part_response_;
    part = part_;
  }
  const Batch batch =
      response == nullptr
          ? Batch()
          : PrepareResponse(*request, part, pool_->observation_bytes(), &response->message);
  pool_->RunPart(request->request, part, batch, [self = shared_from_this()](absl::Status status) {
    self->OnPartDone(std::move(status));
  });
}

void StepPoolReactor::OnPartDone(absl::Status status) {
  bool is_last = false;
  {
    absl::MutexLock lock(&mutex_);
    Response* response = std::exchange(part_response_, nullptr);
    const Request& request = running_->request;
    const int32_t end = part_.first + part_.count;
    const int32_t rest = request.first + request.count - end;
    is_last = !status.ok() || rest == 0;
    if (!status.ok()) {
      FailLocked(status);
    }
    if (response != nullptr && status.ok() && !cancelled_) {
      CompleteResponse(pool_->observation_bytes(), &response->message);
      response->answered = is_last ? running_ : nullptr;
      written_.push_back(response);
    } else if (response != nullptr) {
      free_responses_.push_back(response);
    }
    if (!is_last) {
      part_ = {end, std::min(part_.count, rest)};
      part_waits_ = true;
    }
  }
  if (is_last) {
    EndTurn();
  }
  Drive();
}

void StepPoolReactor::EndTurn() {
  pool_->EndTurn();
  absl::MutexLock lock(&mutex_);
  running_ = nullptr;
}

void StepPoolReactor::Write() {
  Response* response = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    response = written_.front();
  }
  bool own_buffer = false;
  response->bytes.Clear();
  grpc::SerializationTraits<v1::StepPoolResponse>::Serialize(response->message, &response->bytes,
                                                             &own_buffer);
  StartWrite(&response->bytes);
}

void StepPoolReactor::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    Response* response = written_.front();
    written_.pop_front();
    writing_ = false;
    free_responses_.push_back(response);
    if (response->answered != nullptr) {
      free_slots_.push_back(response->answered);
    }
    if (!ok) {
      CancelLocked();
    }
  }
  Drive();
}

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
  const size_t kept = writing_ ? 1 : 0;
  while (written_.size() > kept) {
    free_responses_.push_back(written_.back());
    written_.pop_back();
  }
}

void StepPoolReactor::FinishStream() {
  absl::Status status;
  bool attached = false;
  {
    absl::MutexLock lock(&mutex_);
    status = status_;
    attached = attached_;
  }
  if (attached) {
    pool_->Detach();
    LogEvent(status.ok() ? LogLevel::kInfo : LogLevel::kWarning, "stream_ended",
             {{"pool", pool_->name()},
              {"owner", pool_->owner()},
              {"code", absl::StatusCodeToString(status.code())},
              {"message", std::string(status.message())}});
  }
  Finish(ToGrpcStatus(status));
}

void StepPoolReactor::OnDone() { const std::shared_ptr<StepPoolReactor> last = std::move(self_); }

}  // namespace procgen
