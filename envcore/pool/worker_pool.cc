#include "envcore/pool/worker_pool.h"

#include <algorithm>

#include "envcore/pool/spin_wait.h"

namespace procgen {
namespace {

// A worker takes its part in about this many pieces: enough for the workers to finish together, few
// enough that the atomic operations cost nothing.
constexpr int32_t kGrabsPerPart = 32;

}  // namespace

WorkerPool::WorkerPool(int32_t thread_count) {
  threads_.reserve(static_cast<size_t>(thread_count));
  for (int32_t worker = 0; worker < thread_count; ++worker) {
    threads_.emplace_back([this, worker] { WorkLoop(worker); });
  }
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_arrived_.notify_all();
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

void WorkerPool::Prepare(ParallelJob& job, int32_t item_count, int32_t part_count) {
  if (job.parts_.size() != static_cast<size_t>(part_count)) {
    job.parts_ = std::vector<ParallelJob::Part>(static_cast<size_t>(part_count));
  }
  int32_t begin = 0;
  for (int32_t i = 0; i < part_count; ++i) {
    ParallelJob::Part& part = job.parts_[static_cast<size_t>(i)];
    part.taken_count.store(0, std::memory_order_relaxed);
    part.begin = begin;
    begin += item_count / part_count + (i < item_count % part_count ? 1 : 0);
    part.end = begin;
  }
  job.backwards_ = !job.backwards_;
  job.items_per_grab_ = std::max(1, item_count / (part_count * kGrabsPerPart));
  job.workers_inside_ = 0;
}

void WorkerPool::Submit(ParallelJob& job, int32_t item_count) {
  Prepare(job, item_count, thread_count());
  Announce(job);
}

void WorkerPool::SubmitAndParticipate(ParallelJob& job, int32_t item_count) {
  Prepare(job, item_count, worker_count());
  job.workers_inside_ = 1;
  // A single item runs on the calling thread; no worker is woken for it.
  if (!threads_.empty() && item_count > 1) {
    Announce(job);
  }
  Work(job, thread_count());
  Leave(job);
}

void WorkerPool::Announce(ParallelJob& job) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(&job);
    work_waits_.store(true, std::memory_order_relaxed);
  }
  work_arrived_.notify_all();
}

void WorkerPool::WorkLoop(int32_t worker) {
  while (true) {
    ParallelJob* job = nullptr;
    SpinUntil([this] { return work_waits_.load(std::memory_order_relaxed); });
    {
      std::unique_lock lock(mutex_);
      work_arrived_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
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

void WorkerPool::Work(ParallelJob& job, int32_t worker) {
  for (size_t i = 0; i < job.parts_.size(); ++i) {
    ParallelJob::Part& part = job.parts_[(static_cast<size_t>(worker) + i) % job.parts_.size()];
    while (true) {
      const int32_t count = part.end - part.begin;
      const int32_t first =
          part.taken_count.fetch_add(job.items_per_grab_, std::memory_order_relaxed);
      if (first >= count) {
        break;
      }
      const int32_t end = std::min(first + job.items_per_grab_, count);
      for (int32_t taken = first; taken < end; ++taken) {
        job.RunItem(job.backwards_ ? part.end - 1 - taken : part.begin + taken, worker);
      }
    }
  }
}

void WorkerPool::Leave(ParallelJob& job) {
  {
    const std::lock_guard lock(mutex_);
    const auto place = std::find(waiting_.begin(), waiting_.end(), &job);
    if (place != waiting_.end()) {
      waiting_.erase(place);
      work_waits_.store(!waiting_.empty(), std::memory_order_relaxed);
    }
    if (--job.workers_inside_ > 0) {
      return;
    }
  }
  job.OnDone();
}

}  // namespace procgen
