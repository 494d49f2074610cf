#include "server/pool/watch/frame_publishers.h"

#include <sys/resource.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace procgen {
namespace {

// A low scheduling priority: a tenth of a worker's time on a contended core. At the lowest, a
// seventieth, the first picture took more than a minute beside ten busy programs.
constexpr int kDrawingNiceness = 10;

}  // namespace

FramePublishers::FramePublishers()
    : timer_(SteadyNow, [this](absl::Time now) { return OnTimer(now); }) {
  // On Linux this applies to the thread. If it is refused, drawing costs the learners more.
  drawing_.Run("", [] { setpriority(PRIO_PROCESS, 0, kDrawingNiceness); });
}

absl::Status FramePublishers::Subscribe(const std::shared_ptr<PoolSession>& pool,
                                        const WatchSpec& spec, const FrameSetEncoder& encode,
                                        const std::shared_ptr<FrameSubscriber>& subscriber) {
  std::optional<absl::Cord> frame_set;
  {
    absl::MutexLock lock(&mutex_);
    const Key key(pool.get(), spec);
    std::shared_ptr<FramePublisher>& publisher = publishers_[key];
    if (publisher != nullptr) {
      frame_set = publisher->Subscribe(subscriber);
    }
    if (!frame_set.has_value()) {
      publisher = std::make_shared<FramePublisher>(pool, spec, encode, &drawing_);
      absl::Status status = pool->AddObserver(publisher);
      if (status.ok() && !(frame_set = publisher->Subscribe(subscriber)).has_value()) {
        status = pool->AddObserver(publisher);  // returns why the pool cannot be watched
      }
      if (!status.ok()) {
        publishers_.erase(key);
        return status;
      }
    }
    publisher_of_[subscriber.get()] = publisher;
  }
  if (frame_set->empty()) {
    timer_.ArmBy(timer_.Now());
  } else {
    subscriber->Take(*frame_set);
  }
  return absl::OkStatus();
}

void FramePublishers::Unsubscribe(const FrameSubscriber* subscriber) {
  std::shared_ptr<FramePublisher> publisher;  // freed outside the lock, with its pool
  absl::MutexLock lock(&mutex_);
  const auto subscription = publisher_of_.find(subscriber);
  if (subscription == publisher_of_.end()) {
    return;
  }
  publisher = std::move(subscription->second);
  publisher_of_.erase(subscription);
  if (!publisher->Unsubscribe(subscriber)) {
    return;
  }
  publisher->pool().RemoveObserver(publisher.get());
  const auto found = publishers_.find(Key(&publisher->pool(), publisher->spec()));
  if (found != publishers_.end() && found->second == publisher) {
    publishers_.erase(found);
  }
}

absl::Time FramePublishers::OnTimer(absl::Time now) {
  std::vector<std::shared_ptr<FramePublisher>> publishers;
  {
    absl::MutexLock lock(&mutex_);
    for (const auto& [key, publisher] : publishers_) {
      publishers.push_back(publisher);
    }
  }
  absl::Time next = absl::InfiniteFuture();
  for (const std::shared_ptr<FramePublisher>& publisher : publishers) {
    next = std::min(next, publisher->Tick(now));
  }
  return next;
}

}  // namespace procgen
