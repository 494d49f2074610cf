#ifndef ENVCORE_POOL_WORKER_POOL_H_
#define ENVCORE_POOL_WORKER_POOL_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

class WorkerPool;

// Work for a worker pool: items [0, item_count) that can be done in any order and at the same time.
// Reusable once it is done.
class ParallelJob {
 public:
  virtual ~ParallelJob() = default;

 protected:
  // Does one item. `worker` in [0, WorkerPool::worker_count()): no two threads have the same number
  // at the same time.
  virtual void RunItem(int32_t item, int32_t worker) = 0;
  // All items are done; called once, by the last worker to leave the job. The job may be submitted
  // again, or go, here.
  virtual void OnDone() = 0;

 private:
  friend class WorkerPool;

  // Items that lie side by side; one worker begins with them, so that what it did the last time it
  // finds in its cache.
  struct alignas(64) Part {
    std::atomic<int32_t> taken_count = 0;  // may exceed the count of items
    int32_t begin = 0;
    int32_t end = 0;
  };

  std::vector<Part> parts_;
  // Every other run takes the parts from their ends: a cache that is too small for all items holds
  // those that were done last, and beginning with the others would drive them out one by one.
  bool backwards_ = true;
  int32_t items_per_grab_ = 1;
  int32_t workers_inside_ = 0;  // guarded by the worker pool's mutex
};

// A pool of worker threads that does the work of all pools of a process, first come first served.
// A job that comes again is divided in the same way again.
// Threads: any method from any thread.
class WorkerPool {
 public:
  // `thread_count` >= 0. With 0 only SubmitAndParticipate works, and the calling thread does it
  // all; a server wants one a core.
  explicit WorkerPool(int32_t thread_count);
  // REQUIRES: no job is running or waiting.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // Worker numbers are below this: the threads and, for each job, one caller of
  // SubmitAndParticipate.
  int32_t worker_count() const { return static_cast<int32_t>(threads_.size()) + 1; }
  int32_t thread_count() const { return static_cast<int32_t>(threads_.size()); }

  // Has the threads do `job` and returns at once. REQUIRES: thread_count() > 0; the job stays until
  // OnDone.
  void Submit(ParallelJob& job, int32_t item_count);
  // As Submit, and the calling thread takes part as worker number thread_count(). Returns once it
  // has nothing left to do, which may be before OnDone; a job of one item it does alone, OnDone
  // included. Works without threads, too.
  void SubmitAndParticipate(ParallelJob& job, int32_t item_count);

 private:
  // Divides the items into parts, one for each worker that is expected.
  static void Prepare(ParallelJob& job, int32_t item_count, int32_t part_count);
  void WorkLoop(int32_t worker);
  // Takes items of the job until there are none left, of the worker's own part first.
  static void Work(ParallelJob& job, int32_t worker);
  // Leaves a job that has no items left to take; tells it when it was the last to leave.
  void Leave(ParallelJob& job);

  absl::Mutex mutex_;
  std::deque<ParallelJob*> waiting_
      ABSL_GUARDED_BY(mutex_);  // jobs with items left to take, oldest first
  // Whether there is something in waiting_, for workers that look before they lock.
  std::atomic<bool> work_waits_ = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_WORKER_POOL_H_
