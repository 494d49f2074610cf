#include "server/concurrency/background_executor.h"

#include <utility>

namespace procgen {

BackgroundExecutor::BackgroundExecutor(int32_t thread_count) {
  threads_.reserve(static_cast<size_t>(thread_count));
  for (int32_t i = 0; i < thread_count; ++i) {
    threads_.emplace_back([this] { WorkUntilStopped(); });
  }
}

BackgroundExecutor::~BackgroundExecutor() {
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
  }
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

void BackgroundExecutor::Run(absl::string_view owner, Work work) {
  absl::MutexLock lock(&mutex_);
  std::deque<Work>& queue = queues_[owner];
  if (queue.empty()) {
    turns_.emplace_back(owner);
  }
  queue.push_back(std::move(work));
}

BackgroundExecutor::Work BackgroundExecutor::TakeNext() {
  const auto queue = queues_.find(turns_.front());
  Work work = std::move(queue->second.front());
  queue->second.pop_front();
  if (queue->second.empty()) {
    queues_.erase(queue);
  } else {
    turns_.push_back(std::move(turns_.front()));
  }
  turns_.pop_front();
  return work;
}

void BackgroundExecutor::WorkUntilStopped() {
  while (true) {
    Work work;
    {
      absl::MutexLock lock(&mutex_);
      mutex_.Await(absl::Condition(this, &BackgroundExecutor::HasWorkOrStops));
      if (turns_.empty()) {
        return;
      }
      work = TakeNext();
    }
    work();
  }
}

}  // namespace procgen
