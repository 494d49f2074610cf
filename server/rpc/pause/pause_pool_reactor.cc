#include "server/rpc/pause/pause_pool_reactor.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {

PausePoolReactor* PausePoolReactor::Start(PoolSupervisor* supervisor,
                                          const CallAccounting* accounting, Caller caller) {
  const std::shared_ptr<PausePoolReactor> reactor(
      new PausePoolReactor(supervisor, accounting, std::move(caller)));
  reactor->self_ = reactor;
  reactor->StartRead(&reactor->request_);
  return reactor.get();
}

PausePoolReactor::PausePoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                   Caller caller)
    : supervisor_(supervisor),
      accounting_(accounting),
      owner_(std::move(caller.owner)),
      reservation_(std::move(caller.reservation)) {}

absl::Status PausePoolReactor::Pause() {
  if (supervisor_->draining()) {
    return PoolSupervisor::Draining();
  }
  absl::StatusOr<std::shared_ptr<PoolSession>> pool = supervisor_->Find(owner_, request_.name());
  if (!pool.ok()) {
    return pool.status();
  }
  if (absl::Status status = (*pool)->AddObserver(shared_from_this()); !status.ok()) {
    return status;
  }
  {
    absl::MutexLock lock(&mutex_);
    pool_ = *pool;
    if (end_.has_value()) {
      return absl::OkStatus();  // it has ended meanwhile
    }
    is_paused_ = true;
    (*pool)->Pause();
  }
  (*pool)->TakeTurn([self = shared_from_this(), pool = *pool](const absl::Status& turn) {
    if (turn.ok()) {
      pool->EndTurn();
      self->Respond();
    } else {
      self->End(turn);
    }
  });
  return absl::OkStatus();
}

void PausePoolReactor::OnReadDone(bool ok) {
  if (!ok) {
    End(absl::OkStatus());
    return;
  }
  std::shared_ptr<PoolSession> pool;
  {
    absl::MutexLock lock(&mutex_);
    pool = pool_;
  }
  if (pool == nullptr) {
    if (absl::Status status = Pause(); !status.ok()) {
      End(status);
    }
  } else if (!request_.name().empty()) {
    End(absl::InvalidArgumentError(absl::StrCat("name is '", request_.name().substr(0, 128),
                                                "' again, allowed: empty in further requests")));
  } else {
    pool->StepPaused();
    Respond();
  }
}

void PausePoolReactor::Respond() {
  {
    absl::MutexLock lock(&mutex_);
    if (end_.has_value()) {
      return;
    }
    is_writing_ = true;
  }
  StartWrite(&response_);
}

void PausePoolReactor::OnWriteDone(bool ok) {
  std::optional<absl::Status> end;
  {
    absl::MutexLock lock(&mutex_);
    is_writing_ = false;
    end = end_;
  }
  if (end.has_value()) {
    Finish(*end);
  } else if (ok) {
    StartRead(&request_);
  } else {
    End(absl::OkStatus());  // the client has disconnected
  }
}

void PausePoolReactor::End(const absl::Status& status) {
  std::shared_ptr<PoolSession> paused;
  bool can_finish = false;
  {
    absl::MutexLock lock(&mutex_);
    if (end_.has_value()) {
      return;
    }
    end_ = status;
    can_finish = !is_writing_;
    paused = is_paused_ ? pool_ : nullptr;
  }
  if (paused != nullptr) {
    paused->EndPause();  // without the lock: the learner's request may run in it
  }
  if (can_finish) {
    Finish(status);
  }
}

void PausePoolReactor::Finish(const absl::Status& status) {
  grpc::ServerBidiReactor<v1::PausePoolRequest, v1::PausePoolResponse>::Finish(
      accounting_->EndCall("PoolService/PausePool", status));
}

void PausePoolReactor::OnEnd(const absl::Status& reason) { End(reason); }

void PausePoolReactor::OnCancel() { End(absl::CancelledError("the caller has gone")); }

void PausePoolReactor::OnDone() {
  std::shared_ptr<PoolSession> pool;
  {
    absl::MutexLock lock(&mutex_);
    pool = std::move(pool_);
  }
  if (pool != nullptr) {
    pool->RemoveObserver(this);
  }
  reservation_ = Quotas::Reservation();
  const std::shared_ptr<PausePoolReactor> last = std::move(self_);
}

}  // namespace procgen
