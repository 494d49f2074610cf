#include "envcore/pool/crew.h"

#include <algorithm>

namespace procgen {
namespace {

// A worker takes about this share of its part at a time: few enough grabs to cost nothing, small
// enough to end together.
constexpr int32_t kGrabsPerWorker = 8;

}  // namespace

Crew::Crew(int32_t thread_count) {
  threads_.reserve(static_cast<size_t>(thread_count));
  for (int32_t worker = 0; worker < thread_count; ++worker) {
    threads_.emplace_back([this, worker] { WorkLoop(worker); });
  }
}

Crew::~Crew() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

void Crew::Prepare(CrewJob& job, int32_t item_count) const {
  job.item_count_ = item_count;
  job.items_per_grab_ = std::max(1, item_count / (worker_count() * kGrabsPerWorker));
  job.next_item_.store(0, std::memory_order_relaxed);
  job.workers_inside_ = 0;
}

void Crew::Submit(CrewJob& job, int32_t item_count) {
  Prepare(job, item_count);
  absl::MutexLock lock(&mutex_);
  waiting_.push_back(&job);
}

void Crew::SubmitAndHelp(CrewJob& job, int32_t item_count) {
  Prepare(job, item_count);
  {
    absl::MutexLock lock(&mutex_);
    job.workers_inside_ = 1;
    if (!threads_.empty()) {
      waiting_.push_back(&job);
    }
  }
  Work(job, thread_count());
  Leave(job);
}

void Crew::WorkLoop(int32_t worker) {
  const auto has_work = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stopping_ || !waiting_.empty();
  };
  while (true) {
    CrewJob* job = nullptr;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(&has_work));
      if (waiting_.empty()) {
        return;
      }
      job = waiting_.front();
      ++job->workers_inside_;
    }
    Work(*job, worker);
    Leave(*job);
  }
}

void Crew::Work(CrewJob& job, int32_t worker) {
  while (true) {
    const int32_t first = job.next_item_.fetch_add(job.items_per_grab_, std::memory_order_relaxed);
    if (first >= job.item_count_) {
      return;
    }
    const int32_t end = std::min(first + job.items_per_grab_, job.item_count_);
    for (int32_t item = first; item < end; ++item) {
      job.RunItem(item, worker);
    }
  }
}

void Crew::Leave(CrewJob& job) {
  {
    absl::MutexLock lock(&mutex_);
    const auto place = std::find(waiting_.begin(), waiting_.end(), &job);
    if (place != waiting_.end()) {
      waiting_.erase(place);
    }
    if (--job.workers_inside_ > 0) {
      return;
    }
  }
  job.OnDone();
}

}  // namespace procgen
