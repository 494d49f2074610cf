#include "server/rpc/watch_pool_reactor.h"

#include <utility>

#include "procgen/v1/render.pb.h"
#include "server/rpc/method_name.h"
#include "server/rpc/shared_bytes.h"

namespace procgen {

WatchPoolReactor* WatchPoolReactor::Start(PoolViews* views, const Callers* callers,
                                          std::shared_ptr<PoolSession> pool,
                                          const WatchOrder& order, const EncodeMoment& encode,
                                          Owners::Share share) {
  std::shared_ptr<WatchPoolReactor> reactor(new WatchPoolReactor(views, callers, std::move(share)));
  reactor->self_ = reactor;
  if (absl::Status status = views->Watch(std::move(pool), order, encode, reactor); !status.ok()) {
    reactor->End(status);
  }
  return reactor.get();
}

WatchPoolReactor::WatchPoolReactor(PoolViews* views, const Callers* callers, Owners::Share share)
    : views_(views), callers_(callers), share_(std::move(share)) {}

bool WatchPoolReactor::IsReady() {
  absl::MutexLock lock(&mutex_);
  return !writes_ && !waiting_.has_value();
}

void WatchPoolReactor::Take(const absl::Cord& moment) {
  {
    absl::MutexLock lock(&mutex_);
    waiting_ = moment;
  }
  Continue();
}

void WatchPoolReactor::End(const absl::Status& reason) {
  {
    absl::MutexLock lock(&mutex_);
    if (end_.has_value()) {
      return;
    }
    end_ = reason;
  }
  Continue();
}

void WatchPoolReactor::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    writes_ = false;
  }
  if (ok) {
    Continue();
  } else {
    End(absl::OkStatus());  // who watched has gone
  }
}

void WatchPoolReactor::OnCancel() { End(absl::OkStatus()); }

void WatchPoolReactor::OnDone() {
  views_->Leave(this);
  share_ = Owners::Share();  // a moment that is still on its way to this may hold it for a while
  const std::shared_ptr<WatchPoolReactor> self = std::move(self_);
}

void WatchPoolReactor::Continue() {
  absl::Cord moment;
  std::optional<absl::Status> end;
  {
    absl::MutexLock lock(&mutex_);
    if (writes_ || ended_ || !(end_.has_value() || waiting_.has_value())) {
      return;
    }
    end = end_;
    ended_ = end.has_value();
    writes_ = !ended_;
    if (waiting_.has_value()) {
      moment = *std::exchange(waiting_, std::nullopt);
    }
  }
  if (end.has_value()) {
    // A lease that ran out ends a watch as a deletion does.
    const absl::Status status = absl::IsNotFound(*end) ? absl::AbortedError(end->message()) : *end;
    Finish(callers_->Dismiss(MethodNameOf<v1::WatchPoolRequest>(), status));
    return;
  }
  response_ = ByteBufferOf(moment);
  StartWrite(&response_);
}

}  // namespace procgen
