#ifndef ENVCORE_POOL_WORKER_POOL_H_
#define ENVCORE_POOL_WORKER_POOL_H_

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

namespace procgen {

class WorkerPool;

// Work for a worker pool: items [0, item_count), which can run in any order and concurrently. A job
// can be submitted again once it is done.
class ParallelJob {
 public:
  virtual ~ParallelJob() = default;

 protected:
  // Runs one item. `worker`: in [0, WorkerPool::worker_count()). No two threads have the same
  // worker number at the same time.
  virtual void RunItem(int32_t item, int32_t worker) = 0;
  // Called once, when all items are done, by the last worker to leave the job. May submit the job
  // again or destroy it.
  virtual void OnDone() = 0;

 private:
  friend class WorkerPool;

  // A contiguous range of items. The same worker starts with it in each run, so the data is still
  // in that worker's cache.
  struct alignas(64) Part {
    std::atomic<int32_t> taken_count = 0;  // may exceed the number of items
    int32_t begin = 0;
    int32_t end = 0;
  };

  std::vector<Part> parts_;
  // Every other run takes the items of each part from the end. A cache that is too small for all
  // items holds those that ran last; starting with the others would evict them one by one.
  bool backwards_ = true;
  int32_t items_per_grab_ = 1;
  int32_t workers_inside_ = 0;  // guarded by the worker pool's mutex
};

// A pool of worker threads that all pools of a process share. Jobs run first come, first served. A
// job that is submitted again is divided into the same parts, so each worker finds its items in its
// cache.
// Threads: thread-safe.
class WorkerPool {
 public:
  // `thread_count`: at least 0; one per core in a server. With 0 only SubmitAndParticipate works,
  // and the calling thread does all the work.
  explicit WorkerPool(int32_t thread_count);
  // REQUIRES: no job is running or queued.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // Upper bound of worker numbers: the threads and, for each job, one caller of
  // SubmitAndParticipate.
  int32_t worker_count() const { return static_cast<int32_t>(threads_.size()) + 1; }
  int32_t thread_count() const { return static_cast<int32_t>(threads_.size()); }

  // Queues `job` for the threads and returns immediately. REQUIRES: thread_count() > 0; `job` lives
  // until OnDone.
  void Submit(ParallelJob& job, int32_t item_count);
  // Like Submit, but the calling thread participates as worker number thread_count(). Returns when
  // no items are left to take, which may be before OnDone. A job of one item runs on the calling
  // thread alone, including OnDone. Works without threads.
  void SubmitAndParticipate(ParallelJob& job, int32_t item_count);

 private:
  // Queues a prepared job and wakes the threads.
  void Announce(ParallelJob& job);
  // Divides the items into parts, one per expected worker.
  static void Prepare(ParallelJob& job, int32_t item_count, int32_t part_count);
  void WorkLoop(int32_t worker);
  // Takes items of the job until none are left, starting with the worker's own part.
  static void Work(ParallelJob& job, int32_t worker);
  // Leaves a job that has no items left to take. The last worker to leave calls OnDone.
  void Leave(ParallelJob& job);

  std::mutex mutex_;
  std::condition_variable work_arrived_;  // or stopping_
  std::deque<ParallelJob*> waiting_;  // jobs with items left to take, oldest first; under mutex_
  // Whether waiting_ is non-empty, for workers that poll before they lock.
  std::atomic<bool> work_waits_ = false;
  bool stopping_ = false;  // under mutex_
  std::vector<std::thread> threads_;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_WORKER_POOL_H_
