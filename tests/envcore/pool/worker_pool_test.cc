#include "envcore/pool/worker_pool.h"

#include <atomic>
#include <functional>
#include <latch>
#include <thread>
#include <vector>

#include "absl/synchronization/blocking_counter.h"
#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::Each;
using ::testing::Eq;

// Counts how often each item runs.
class CountingJob : public ParallelJob {
 public:
  explicit CountingJob(int32_t item_count) : counts_(static_cast<size_t>(item_count)) {}

  std::function<void()> on_done = [] {};
  std::function<void(int32_t item, int32_t worker)> on_item = [](int32_t, int32_t) {};

  int32_t item_count() const { return static_cast<int32_t>(counts_.size()); }
  std::vector<int> Counts() const { return {counts_.begin(), counts_.end()}; }

 protected:
  void RunItem(int32_t item, int32_t worker) override {
    counts_[static_cast<size_t>(item)].fetch_add(1, std::memory_order_relaxed);
    on_item(item, worker);
  }
  void OnDone() override { on_done(); }

 private:
  std::vector<std::atomic<int>> counts_;
};

class WorkerPoolSizesTest : public testing::TestWithParam<int32_t> {};

TEST_P(WorkerPoolSizesTest, RunsEveryItemOnce) {
  WorkerPool workers(GetParam());
  for (const int32_t item_count : {0, 1, 2, 7, 64, 1000}) {
    CountingJob job(item_count);
    absl::Notification done;
    job.on_done = [&done] { done.Notify(); };
    workers.SubmitAndParticipate(job, item_count);
    done.WaitForNotification();
    EXPECT_THAT(job.Counts(), Each(Eq(1))) << item_count << " items";
  }
}

TEST_P(WorkerPoolSizesTest, WorkerNumbersAreBelowTheWorkerCountAndNeverUsedConcurrently) {
  WorkerPool workers(GetParam());
  ASSERT_EQ(workers.worker_count(), GetParam() + 1);
  CountingJob job(500);
  std::vector<std::atomic<int>> busy(static_cast<size_t>(workers.worker_count()));
  std::atomic<int> clashes = 0;
  job.on_item = [&](int32_t /*item*/, int32_t worker) {
    std::atomic<int>& mine = busy.at(static_cast<size_t>(worker));
    clashes += mine.exchange(1);
    std::this_thread::yield();
    mine = 0;
  };
  absl::Notification done;
  job.on_done = [&done] { done.Notify(); };
  workers.SubmitAndParticipate(job, job.item_count());
  done.WaitForNotification();
  EXPECT_EQ(clashes, 0);
}

INSTANTIATE_TEST_SUITE_P(Sizes, WorkerPoolSizesTest, testing::Values(0, 1, 2, 5));

TEST(WorkerPoolTest, WithoutThreadsTheCallerRunsAllItems) {
  WorkerPool workers(0);
  CountingJob job(20);
  const std::thread::id caller = std::this_thread::get_id();
  bool all_here = true;
  bool done = false;
  job.on_item = [&](int32_t /*item*/, int32_t worker) {
    all_here = all_here && std::this_thread::get_id() == caller && worker == 0;
  };
  job.on_done = [&done] { done = true; };
  workers.SubmitAndParticipate(job, 20);
  EXPECT_TRUE(all_here);
  EXPECT_TRUE(done) << "no other worker can finish the job";
}

TEST(WorkerPoolTest, ASingleItemRunsOnTheCallerAndWakesNoWorker) {
  WorkerPool workers(2);
  for (int round = 0; round < 200; ++round) {
    CountingJob job(1);
    std::thread::id here;
    bool done = false;
    job.on_item = [&here](int32_t /*item*/, int32_t /*worker*/) {
      here = std::this_thread::get_id();
    };
    job.on_done = [&done] { done = true; };
    workers.SubmitAndParticipate(job, 1);
    ASSERT_EQ(here, std::this_thread::get_id());
    ASSERT_TRUE(done);
  }
}

TEST(WorkerPoolTest, EachWorkerStartsWithItsOwnItemsWhereItEndedBefore) {
  constexpr int32_t kItemCount = 40;
  WorkerPool workers(1);
  CountingJob job(kItemCount);
  for (int round = 0; round < 3; ++round) {
    std::latch both_came(2);
    std::vector<std::vector<int32_t>> items(2);  // by worker
    job.on_item = [&](int32_t item, int32_t worker) {
      std::vector<int32_t>& mine = items.at(static_cast<size_t>(worker));
      mine.push_back(item);
      if (mine.size() == 1) {
        both_came.arrive_and_wait();  // no worker takes all items before the other has started
      }
    };
    absl::Notification done;
    job.on_done = [&done] { done.Notify(); };
    workers.SubmitAndParticipate(job, kItemCount);
    done.WaitForNotification();
    const bool backwards = round % 2 == 1;
    EXPECT_EQ(items[0].front(), backwards ? kItemCount / 2 - 1 : 0);
    EXPECT_EQ(items[1].front(), backwards ? kItemCount - 1 : kItemCount / 2);
  }
}

TEST(WorkerPoolTest, SubmitLeavesTheWorkToTheThreads) {
  WorkerPool workers(2);
  CountingJob job(50);
  std::atomic<bool> here = false;
  const std::thread::id caller = std::this_thread::get_id();
  absl::Notification done;
  job.on_item = [&](int32_t /*item*/, int32_t /*worker*/) {
    here = here || std::this_thread::get_id() == caller;
  };
  job.on_done = [&done] { done.Notify(); };
  workers.Submit(job, 50);
  done.WaitForNotification();
  EXPECT_FALSE(here);
  EXPECT_THAT(job.Counts(), Each(Eq(1)));
}

TEST(WorkerPoolTest, ManyJobsFromManyThreadsAreAllDone) {
  constexpr int kThreadCount = 6;
  constexpr int kRoundCount = 40;
  WorkerPool workers(3);
  std::vector<std::thread> threads;
  threads.reserve(kThreadCount);
  std::atomic<int> wrong = 0;
  for (int t = 0; t < kThreadCount; ++t) {
    threads.emplace_back([&workers, &wrong, t] {
      CountingJob job(17 + t);
      for (int round = 1; round <= kRoundCount; ++round) {
        absl::Notification done;
        job.on_done = [&done] { done.Notify(); };
        if ((round + t) % 2 == 0) {
          workers.Submit(job, job.item_count());
        } else {
          workers.SubmitAndParticipate(job, job.item_count());
        }
        done.WaitForNotification();
        for (const int count : job.Counts()) {
          wrong += count == round ? 0 : 1;
        }
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
}

TEST(WorkerPoolTest, AJobMayBeDestroyedWhenItIsDone) {
  WorkerPool workers(3);
  constexpr int kJobCount = 50;
  absl::BlockingCounter left(kJobCount);
  for (int i = 0; i < kJobCount; ++i) {
    auto* job = new CountingJob(5);
    job->on_done = [job, &left] {
      absl::BlockingCounter* counter = &left;
      delete job;  // also destroys this function and its captures
      counter->DecrementCount();
    };
    workers.Submit(*job, 5);
  }
  left.Wait();
}

TEST(WorkerPoolTest, JobsAfterALongOneDoNotWaitForIt) {
  WorkerPool workers(2);
  absl::Notification gate;
  absl::Notification long_done;
  absl::Notification short_done;
  CountingJob long_job(1);
  long_job.on_item = [&gate](int32_t, int32_t) { gate.WaitForNotification(); };
  long_job.on_done = [&long_done] { long_done.Notify(); };
  CountingJob short_job(30);
  short_job.on_done = [&short_done] { short_done.Notify(); };
  workers.Submit(long_job, 1);
  workers.Submit(short_job, 30);
  short_done.WaitForNotification();
  EXPECT_FALSE(long_done.HasBeenNotified());
  gate.Notify();
  long_done.WaitForNotification();
}

}  // namespace
}  // namespace procgen
