#include "server/rpc/dm_env_rpc/dm_env_rpc_reactor.h"

#include <utility>

#include "server/rpc/call/drain_trailer.h"
#include "server/rpc/call/drive_guard.h"
#include "server/rpc/grpc/method_name.h"
#include "server/rpc/grpc/parse_message.h"

namespace procgen {

std::shared_ptr<DmEnvRpcReactor> DmEnvRpcReactor::Start(PoolSupervisor* supervisor,
                                                        JoinedWorlds* worlds,
                                                        const CallAccounting* accounting,
                                                        grpc::CallbackServerContext* context,
                                                        Caller caller) {
  // Shared, because the end of a world may be reported after OnDone.
  std::shared_ptr<DmEnvRpcReactor> reactor(
      new DmEnvRpcReactor(supervisor, accounting, context, std::move(caller)));
  reactor->self_ = reactor;
  // Weak, because the stream owns the session, which owns its callback.
  reactor->session_ = std::make_unique<DmEnvRpcSession>(
      supervisor, worlds, reactor->caller_.owner,
      [weak = reactor->weak_from_this()](const absl::Status& status) {
        if (const std::shared_ptr<DmEnvRpcReactor> stream = weak.lock(); stream != nullptr) {
          stream->End(status);
        }
      });
  reactor->Drive();
  return reactor;
}

DmEnvRpcReactor::DmEnvRpcReactor(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                 grpc::CallbackServerContext* context, Caller caller)
    : supervisor_(supervisor),
      accounting_(accounting),
      context_(context),
      caller_(std::move(caller)) {}

// NOLINTBEGIN(misc-no-recursion): a nested call of Drive returns immediately.
void DmEnvRpcReactor::Drive() {
  const DriveGuard guard(this);
  if (guard.is_nested()) {
    return;
  }
  const std::shared_ptr<DmEnvRpcReactor> self = shared_from_this();
  Action action = Action::kWait;
  do {
    {
      absl::MutexLock lock(&mutex_);
      action = NextAction();
    }
    Act(action);
  } while (action != Action::kWait && action != Action::kFinish);
}

DmEnvRpcReactor::Action DmEnvRpcReactor::NextAction() {
  if (finished_) {
    return Action::kWait;
  }
  if (has_response_ && !writing_ && !cancelled_) {
    has_response_ = false;
    writing_ = true;
    return Action::kWrite;
  }
  const bool busy = answering_ || writing_ || (has_response_ && !cancelled_);
  if (has_request_ && !busy) {
    has_request_ = false;
    answering_ = true;
    request_bytes_.Swap(&read_bytes_);
    return Action::kAnswer;
  }
  if (!reading_ && !has_request_ && !reading_ended_) {
    reading_ = true;
    ++starting_read_count_;
    return Action::kRead;
  }
  if (reading_ended_ && !has_request_ && !busy && starting_read_count_ == 0) {
    finished_ = true;
    return Action::kFinish;
  }
  return Action::kWait;
}

void DmEnvRpcReactor::Act(Action action) {
  switch (action) {
    case Action::kWait:
      return;
    case Action::kRead: {
      StartRead(&read_bytes_);
      absl::MutexLock lock(&mutex_);
      --starting_read_count_;
      return;
    }
    case Action::kAnswer:
      Answer();
      return;
    case Action::kWrite:
      Write();
      return;
    case Action::kFinish:
      FinishStream();
      return;
  }
}

void DmEnvRpcReactor::OnReadDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    reading_ = false;
    reading_ended_ = reading_ended_ || !ok;
    has_request_ = !reading_ended_;
  }
  Drive();
}

void DmEnvRpcReactor::Answer() {
  supervisor_->metrics().AddReceivedBytes(static_cast<int64_t>(request_bytes_.Length()));
  const absl::Status parsed = ParseMessage(request_bytes_, &request_);
  request_bytes_.Clear();
  if (!parsed.ok()) {
    SetError(parsed, &response_);
    OnAnswered(parsed);
    return;
  }
  session_->Answer(request_, &response_, [self = shared_from_this()](const absl::Status& status) {
    self->OnAnswered(status);
  });
}

void DmEnvRpcReactor::OnAnswered(const absl::Status& status) {
  if (!status.ok()) {
    accounting_->EndCall(MethodNameOf<dm::EnvironmentRequest>(), status);
  }
  {
    absl::MutexLock lock(&mutex_);
    answering_ = false;
    has_response_ = true;
  }
  Drive();
}

// NOLINTEND(misc-no-recursion)

void DmEnvRpcReactor::Write() {
  written_bytes_.Clear();
  bool own_buffer = false;
  grpc::SerializationTraits<dm::EnvironmentResponse>::Serialize(response_, &written_bytes_,
                                                                &own_buffer);
  supervisor_->metrics().AddSentBytes(static_cast<int64_t>(written_bytes_.Length()));
  StartWrite(&written_bytes_);
}

void DmEnvRpcReactor::OnWriteDone(bool ok) {
  if (!ok) {
    EndNow(absl::CancelledError(), true);
  }
  {
    absl::MutexLock lock(&mutex_);
    writing_ = false;
  }
  Drive();
}

void DmEnvRpcReactor::OnCancel() { EndNow(absl::CancelledError(), true); }

void DmEnvRpcReactor::End(const absl::Status& status) { EndNow(status, false); }

void DmEnvRpcReactor::EndNow(const absl::Status& status, bool cancelled) {
  {
    absl::MutexLock lock(&mutex_);
    if (finished_) {
      return;
    }
    reading_ended_ = true;
    has_request_ = false;
    cancelled_ = cancelled_ || cancelled;
    if (status_.ok()) {
      status_ = status;
    }
  }
  session_->CancelWait();
  Drive();
}

void DmEnvRpcReactor::FinishStream() {
  session_->End();
  absl::Status status;
  {
    absl::MutexLock lock(&mutex_);
    status = status_;
  }
  AddDrainTrailer(status, *supervisor_, context_);
  Finish(accounting_->EndCall(MethodNameOf<dm::EnvironmentRequest>(), status));
}

void DmEnvRpcReactor::OnDone() { const std::shared_ptr<DmEnvRpcReactor> last = std::move(self_); }

}  // namespace procgen
