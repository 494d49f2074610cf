#ifndef SERVER_POOL_HISTORY_POOL_HISTORY_H_
#define SERVER_POOL_HISTORY_POOL_HISTORY_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace procgen {

// Statistics of a pool in one interval. NaN: no value.
struct PoolHistoryRow {
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  absl::Time time;  // its end, on the wall clock
  // At its end:
  int64_t step_count = 0;
  int64_t episode_count = 0;
  // Means over the interval, but for the lowest and highest return:
  float steps_per_second = kNone;
  float mean_episode_return = kNone;
  float mean_episode_length = kNone;
  float min_episode_return = kNone;
  float max_episode_return = kNone;
  float episode_return_deviation = kNone;
  float request_duration_p50_s = kNone;
  float request_duration_p99_s = kNone;
  std::vector<float> game_returns;  // mean returns of the pool's games; empty for one game
};

// Time series of one pool: a row a second, and coarser rows for longer spans.
// Threads: any method from any thread. Its lock is a leaf.
class PoolHistory {
 public:
  struct Resolution {
    int32_t interval_s = 0;
    size_t rows_max = 0;
  };
  // Ten minutes, an hour, a day; finest first.
  static constexpr std::array<Resolution, 3> kResolutions = {{{1, 600}, {10, 360}, {240, 360}}};
  static constexpr absl::Duration kSpanMax = absl::Hours(24);
  static constexpr absl::Duration kSpanDefault = absl::Minutes(10);
  // Memory of a pool's rows, if they are not limited: 1,320 and those of incomplete intervals.
  static int64_t BytesMax(size_t game_count);

  struct Series {
    absl::Duration interval;
    std::vector<PoolHistoryRow> rows;  // oldest first
  };

  // Adds a row without its `steps_per_second`, which it computes. `bytes_max`: of all rows; the
  // oldest ones of each resolution are dropped. At least one row of each remains.
  void Add(PoolHistoryRow row, int64_t bytes_max) ABSL_LOCKS_EXCLUDED(mutex_);

  // The rows of the last `span`, in the finest resolution that covers it, followed by finer ones
  // for the interval that is not complete.
  Series Read(absl::Duration span) const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // Rows of one resolution.
  struct Rows {
    std::deque<PoolHistoryRow> complete;
    std::vector<PoolHistoryRow> pending;  // finer rows of the interval that is not complete
  };

  // Adds a row to a resolution, and to the coarser ones when their intervals are complete.
  // `share`: of the rows that fit in memory, in (0, 1].
  void AddRow(PoolHistoryRow row, size_t resolution, double share)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable absl::Mutex mutex_;
  std::array<Rows, kResolutions.size()> rows_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_POOL_HISTORY_POOL_HISTORY_H_
