#ifndef SERVER_SESSION_EPISODES_RECENT_EPISODES_H_
#define SERVER_SESSION_EPISODES_RECENT_EPISODES_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// Statistics of a pool's ended episodes: their total count, and means over the most recent ones.
// Threads: any method from any thread. Its lock is a leaf.
class RecentEpisodes {
 public:
  // Number of episodes that the means cover.
  static constexpr size_t kRecentCount = 100;

  struct Summary {
    int64_t count = 0;      // of all episodes
    float mean_return = 0;  // of the last kRecentCount; 0 if none
    float mean_length = 0;  // likewise, in steps
  };

  void Add(float episode_return, int32_t length);
  Summary Read() const;

 private:
  mutable absl::Mutex mutex_;
  int64_t count_ ABSL_GUARDED_BY(mutex_) = 0;
  std::array<float, kRecentCount> returns_ ABSL_GUARDED_BY(mutex_) = {};  // n at n % kRecentCount
  std::array<int32_t, kRecentCount> lengths_ ABSL_GUARDED_BY(mutex_) = {};
};

}  // namespace procgen

#endif  // SERVER_SESSION_EPISODES_RECENT_EPISODES_H_
