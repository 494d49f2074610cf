#include "server/concurrency/thread_group.h"

#include <utility>

#include "server/concurrency/start_thread.h"

namespace procgen {

ThreadGroup::~ThreadGroup() {
  absl::MutexLock lock(&mutex_);
  for (Entry& entry : entries_) {
    entry.thread.join();
  }
}

absl::Status ThreadGroup::Start(std::function<void()> work) {
  absl::MutexLock lock(&mutex_);
  Reap();
  if (entries_.size() >= count_max_) {
    return absl::ResourceExhaustedError(full_error_);
  }
  auto has_ended = std::make_shared<std::atomic<bool>>(false);
  absl::StatusOr<std::thread> thread = StartThread([work = std::move(work), has_ended]() mutable {
    work();
    work = nullptr;  // destroys its captures on this thread, too
    *has_ended = true;
  });
  if (!thread.ok()) {
    return thread.status();
  }
  entries_.push_back({*std::move(thread), has_ended});
  return absl::OkStatus();
}

void ThreadGroup::Reap() {
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    if (*entry->has_ended) {
      entry->thread.join();
      entry = entries_.erase(entry);
    } else {
      ++entry;
    }
  }
}

}  // namespace procgen
