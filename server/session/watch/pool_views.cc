#include "server/session/watch/pool_views.h"

#include <sys/resource.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace procgen {
namespace {

// The least that a thread can have of a busy machine.
constexpr int kNicenessMax = 19;

}  // namespace

PoolViews::PoolViews() : timer_(SteadyNow, [this](absl::Time now) { return OnTimer(now); }) {
  // On Linux that is said of a thread. Where it is refused, pictures cost the learners more.
  drawing_.Run("", [] { setpriority(PRIO_PROCESS, 0, kNicenessMax); });
}

absl::Status PoolViews::Watch(const std::shared_ptr<PoolSession>& pool, const WatchOrder& order,
                              const EncodeMoment& encode, const std::shared_ptr<Watcher>& watcher) {
  std::optional<absl::Cord> moment;
  {
    absl::MutexLock lock(&mutex_);
    const Key key(pool.get(), order);
    std::shared_ptr<PoolView>& view = views_[key];
    if (view != nullptr) {
      moment = view->Join(watcher);
    }
    if (!moment.has_value()) {
      view = std::make_shared<PoolView>(pool, order, encode, &drawing_);
      absl::Status status = pool->AddObserver(view);
      if (status.ok() && !(moment = view->Join(watcher)).has_value()) {
        status = pool->AddObserver(view);  // tells why it has ended meanwhile
      }
      if (!status.ok()) {
        views_.erase(key);
        return status;
      }
    }
    seen_by_[watcher.get()] = view;
  }
  if (moment->empty()) {
    timer_.ArmBy(timer_.Now());
  } else {
    watcher->Take(*moment);
  }
  return absl::OkStatus();
}

void PoolViews::Leave(const Watcher* watcher) {
  std::shared_ptr<PoolView> view;  // freed outside the lock, with its pool
  absl::MutexLock lock(&mutex_);
  const auto seen = seen_by_.find(watcher);
  if (seen == seen_by_.end()) {
    return;
  }
  view = std::move(seen->second);
  seen_by_.erase(seen);
  if (!view->Leave(watcher)) {
    return;
  }
  view->pool().RemoveObserver(view.get());
  const auto found = views_.find(Key(&view->pool(), view->order()));
  if (found != views_.end() && found->second == view) {
    views_.erase(found);
  }
}

absl::Time PoolViews::OnTimer(absl::Time now) {
  std::vector<std::shared_ptr<PoolView>> views;
  {
    absl::MutexLock lock(&mutex_);
    for (const auto& [key, view] : views_) {
      views.push_back(view);
    }
  }
  absl::Time next = absl::InfiniteFuture();
  for (const std::shared_ptr<PoolView>& view : views) {
    next = std::min(next, view->Tick(now));
  }
  return next;
}

}  // namespace procgen
