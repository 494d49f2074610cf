#ifndef SERVER_POOL_EPISODES_RECENT_EPISODES_H_
#define SERVER_POOL_EPISODES_RECENT_EPISODES_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/function_ref.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "server/pool/episodes/episode_recording.h"
#include "server/pool/quota/byte_budget.h"

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

// A pool's ended episodes: their total count, statistics of the most recent ones, a list, and the
// recordings of the last ones in the list, as many as memory allows. Annotations are dropped before
// recordings, those of the best and of the worst episode last.
// Threads: any method from any thread. Its lock is a leaf.
class RecentEpisodes {
 public:
  // Number of episodes that the statistics cover.
  static constexpr size_t kRecentCount = 100;
  // Number of episodes that are listed; about 50 bytes each.
  static constexpr size_t kListedMax = 1000;
  // Memory of the recordings: 1,000 episodes of 4,000 steps.
  static constexpr int64_t kRecordingBytesMax = 4 << 20;
  // Memory of their annotations: 250 episodes of 1,000 steps with 16 values each.
  static constexpr int64_t kAnnotationBytesMax = 16 << 20;

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
    int64_t recorded_count = 0;          // number of last episodes that have a recording
  };

  // Reserves memory for recordings from the first half of `bytes`, which must outlive this.
  explicit RecentEpisodes(ByteBudget* bytes) : bytes_(bytes) {}
  ~RecentEpisodes();
  RecentEpisodes(const RecentEpisodes&) = delete;
  RecentEpisodes& operator=(const RecentEpisodes&) = delete;

  // Adds an episode. Without a recording, those before it are dropped.
  void Add(const EndedEpisode& episode, std::optional<EpisodeRecording> recording);
  // Returns the recording of an environment's episode; nothing: there is none.
  std::optional<EpisodeRecording> Find(int32_t environment, uint64_t fingerprint) const;
  Summary Read() const;
  ReturnSpread ReadReturnSpread() const;
  // The mean returns of groups of environments, each of its last kRecentCount episodes among the
  // listed ones; nullopt: there are none. `group_of`: the group of an environment, below `count`.
  std::vector<std::optional<float>> ReadMeanReturns(
      size_t count, absl::FunctionRef<size_t(int32_t environment)> group_of) const;
  // Returns the last episodes, at most kListedMax, without the first `after` of the pool.
  List ReadList(int64_t after) const;

 private:
  // Number of episodes that the statistics cover now.
  size_t StatisticsCount() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The i-th last episode. REQUIRES: i < episodes_.size().
  const EndedEpisode& Last(size_t i) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Drops the oldest recordings until there is room for another of `bytes`. Returns false if there
  // is none.
  bool Reserve(int64_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Likewise for its annotations; drops the oldest annotations.
  bool ReserveAnnotations(int64_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Drops those of the best and of the worst episode last: they are read most. Returns false if no
  // recording has annotations.
  bool DropOldestAnnotations() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void DropAnnotations(EpisodeRecording* recording) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void DropOldestRecording() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  ByteBudget* const bytes_;
  mutable absl::Mutex mutex_;
  int64_t count_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<EndedEpisode> episodes_ ABSL_GUARDED_BY(mutex_);       // n at n % kListedMax
  std::deque<EpisodeRecording> recordings_ ABSL_GUARDED_BY(mutex_);  // of the last episodes
  int64_t reserved_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t annotation_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen

#endif  // SERVER_POOL_EPISODES_RECENT_EPISODES_H_
