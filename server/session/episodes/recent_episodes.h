#ifndef SERVER_SESSION_EPISODES_RECENT_EPISODES_H_
#define SERVER_SESSION_EPISODES_RECENT_EPISODES_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace procgen {

// An episode that was terminated or truncated.
struct EndedEpisode {
  int32_t environment = 0;
  int32_t level_seed = 0;  // of its last level
  float total_reward = 0;
  int32_t length = 0;  // in steps
  bool is_truncated = false;
  bool level_complete = false;  // by the last action
  uint64_t fingerprint = 0;     // at its end
  absl::Time end_time;
};

// A pool's ended episodes: their total count, statistics of the most recent ones, and a list.
// Threads: any method from any thread. Its lock is a leaf.
class RecentEpisodes {
 public:
  // Number of episodes that the statistics cover.
  static constexpr size_t kRecentCount = 100;
  // Number of episodes that are listed; about 50 bytes each.
  static constexpr size_t kListedMax = 1000;

  struct Summary {
    int64_t count = 0;      // of all episodes
    float mean_return = 0;  // of the last kRecentCount; 0 if none
    float mean_length = 0;  // likewise, in steps
  };
  // Of the returns of the last kRecentCount; 0 if none.
  struct ReturnSpread {
    float min = 0;
    float max = 0;
    float deviation = 0;  // standard deviation
  };
  struct List {
    int64_t count = 0;                   // of all episodes
    std::vector<EndedEpisode> episodes;  // the last ones, oldest first
  };

  void Add(const EndedEpisode& episode);
  Summary Read() const;
  ReturnSpread ReadReturnSpread() const;
  // Returns the last episodes, at most kListedMax, without the first `after` of the pool.
  List ReadList(int64_t after) const;

 private:
  // Number of episodes that the statistics cover now.
  size_t StatisticsCount() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The i-th last episode. REQUIRES: i < episodes_.size().
  const EndedEpisode& Last(size_t i) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable absl::Mutex mutex_;
  int64_t count_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<EndedEpisode> episodes_ ABSL_GUARDED_BY(mutex_);  // n at n % kListedMax
};

}  // namespace procgen

#endif  // SERVER_SESSION_EPISODES_RECENT_EPISODES_H_
