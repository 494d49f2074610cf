#include "server/rpc/run/run_pool_reactor.h"

#include <utility>

#include "server/concurrency/deadline_timer.h"
#include "server/rpc/grpc/parse_message.h"

namespace procgen {
namespace {

// Requests that are read ahead of the one being executed: at most so many, and none beyond so many
// bytes.
constexpr size_t kInboxMax = 16;
constexpr size_t kInboxBytesMax = 1 << 20;
// Responses that wait to be sent: one is drawn while another is sent.
constexpr size_t kOutboxMax = 2;
// Requests larger than this are not used again, so that their memory is freed.
constexpr size_t kReusedBytesMax = 64 << 10;

}  // namespace

RunPoolReactor* RunPoolReactor::Start(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                      grpc::CallbackServerContext* context, Caller caller) {
  std::string owner = caller.owner;
  const std::shared_ptr<RunPoolReactor> reactor(
      new RunPoolReactor(supervisor, accounting, context, std::move(caller)));
  reactor->self_ = reactor;
  reactor->run_ = std::make_shared<PoolRun>(
      supervisor, std::move(owner), [weak = std::weak_ptr(reactor)](const absl::Status& reason) {
        if (const std::shared_ptr<RunPoolReactor> stream = weak.lock(); stream != nullptr) {
          {
            absl::MutexLock lock(&stream->mutex_);
            stream->End(reason);
          }
          stream->Drive();
        }
      });
  reactor->Drive();
  return reactor.get();
}

RunPoolReactor::RunPoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting,
                               grpc::CallbackServerContext* context, Caller caller)
    : supervisor_(supervisor),
      accounting_(accounting),
      context_(context),
      caller_(std::move(caller)) {}

void RunPoolReactor::Drive() {
  Action action = Action::kNone;
  while (true) {
    {
      absl::MutexLock lock(&mutex_);
      if (action == Action::kNone) {
        if (is_driving_) {
          return;  // that thread looks again, because it needs the lock to leave
        }
        is_driving_ = true;
      }
      action = NextAction();
      if (action == Action::kNone) {
        is_driving_ = false;
        return;
      }
    }
    Act(action);
  }
}

RunPoolReactor::Action RunPoolReactor::NextAction() {
  if (is_finished_) {
    return Action::kNone;
  }
  if (!is_executing_ && !is_ending_ && !inbox_.empty() && outbox_.size() < kOutboxMax) {
    is_executing_ = true;
    executing_ = std::move(inbox_.front());
    inbox_.pop_front();
    inbox_bytes_ -= executing_->bytes;
    return Action::kExecute;
  }
  if (!is_writing_ && !outbox_.empty()) {
    is_writing_ = true;
    write_bytes_ = outbox_.front();
    outbox_.pop_front();
    return Action::kWrite;
  }
  if (!is_reading_ && !is_half_closed_ && !is_ending_ && inbox_.size() < kInboxMax &&
      inbox_bytes_ < kInboxBytesMax) {
    is_reading_ = true;
    return Action::kRead;
  }
  const bool is_over = is_ending_ || (is_half_closed_ && inbox_.empty());
  if (is_over && !is_executing_ && !is_writing_ && outbox_.empty()) {
    is_finished_ = true;
    return Action::kFinish;
  }
  return Action::kNone;
}

void RunPoolReactor::Act(Action action) {
  switch (action) {
    case Action::kNone:
      break;
    case Action::kRead:
      StartRead(&read_bytes_);
      break;
    case Action::kExecute:
      Execute();
      break;
    case Action::kWrite:
      supervisor_->metrics().AddSentBytes(static_cast<int64_t>(write_bytes_.Length()));
      StartWrite(&write_bytes_);
      break;
    case Action::kFinish:
      Finish();
      break;
  }
}

void RunPoolReactor::OnReadDone(bool ok) {
  const absl::Time arrival_time = SteadyNow();
  std::unique_ptr<Received> received;
  {
    absl::MutexLock lock(&mutex_);
    if (!ok) {
      is_reading_ = false;
      is_half_closed_ = true;
    } else if (!free_.empty()) {
      received = std::move(free_.back());
      free_.pop_back();
    } else {
      received = std::make_unique<Received>();
    }
  }
  if (ok) {
    supervisor_->metrics().AddReceivedBytes(static_cast<int64_t>(read_bytes_.Length()));
    received->bytes = read_bytes_.Length();
    received->arrival_time = arrival_time;
    const absl::Status parsed = ParseMessage(read_bytes_, &received->message);
    read_bytes_.Clear();
    absl::MutexLock lock(&mutex_);
    is_reading_ = false;
    if (parsed.ok()) {
      inbox_bytes_ += received->bytes;
      inbox_.push_back(std::move(received));
    } else {
      // The requests before it are still answered, or one of them ends the stream.
      is_half_closed_ = true;
      last_read_ = parsed;
    }
  }
  Drive();
}

void RunPoolReactor::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    is_writing_ = false;
    write_bytes_.Clear();
    if (!ok) {
      is_cancelled_ = true;
      End(absl::CancelledError("the learner has disconnected"));
    }
  }
  Drive();
}

void RunPoolReactor::OnCancel() {
  bool has_pool = false;
  {
    absl::MutexLock lock(&mutex_);
    is_cancelled_ = true;
    End(absl::CancelledError("the learner has cancelled the stream or disconnected"));
    has_pool = has_pool_;
  }
  if (has_pool) {
    run_->OnLearnerGone();
  }
  Drive();
}

void RunPoolReactor::OnDone() { self_ = nullptr; }

void RunPoolReactor::Execute() {
  const Received* received = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    received = executing_.get();
  }
  run_->Execute(received->message, received->arrival_time,
                [self = shared_from_this()](absl::StatusOr<grpc::ByteBuffer> response) {
                  self->OnResponse(std::move(response));
                  self->Drive();
                });
}

void RunPoolReactor::OnResponse(absl::StatusOr<grpc::ByteBuffer> response) {
  absl::MutexLock lock(&mutex_);
  is_executing_ = false;
  if (executing_->message.has_start()) {
    has_pool_ = response.ok();
  }
  if (executing_->bytes <= kReusedBytesMax) {
    free_.push_back(std::move(executing_));
  }
  executing_ = nullptr;
  if (!response.ok()) {
    End(response.status());
  } else if (!is_cancelled_) {
    outbox_.push_back(*std::move(response));
  }
}

void RunPoolReactor::End(const absl::Status& status) {
  is_ending_ = true;
  inbox_.clear();
  inbox_bytes_ = 0;
  if (is_cancelled_) {
    outbox_.clear();
  }
  if (status_.ok()) {
    status_ = status;
  }
}

void RunPoolReactor::Finish() {
  run_->Close();
  absl::Status status;
  {
    absl::MutexLock lock(&mutex_);
    status = is_ending_ ? status_ : last_read_;
    caller_ = Caller();
  }
  if (absl::IsUnavailable(status)) {
    context_->AddTrailingMetadata("procgen-drains", "1");
  }
  ServerBidiReactor::Finish(accounting_->EndCall("PoolService/RunPool", status));
}

}  // namespace procgen
