#ifndef SERVER_SESSION_POOL_POOL_COUNTS_H_
#define SERVER_SESSION_POOL_POOL_COUNTS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/metrics/metrics.h"
#include "server/session/backend/request.h"
#include "server/session/episodes/recent_episodes.h"

namespace procgen {

// Counts a pool's steps and the episodes that end in them, for the pool and by game.
// Threads: one at a time, but what is const from any.
class PoolCounts {
 public:
  // `metrics` must outlive this.
  PoolCounts(const PoolOptions& options, Metrics* metrics);

  // Counts what was stepped into `batch`, but for those of `resets`, which began an episode
  // instead; returns the number of steps. `batch`: as BatchNumbers lends it.
  int64_t Add(Part part, absl::Span<const Reset> resets, const Batch& batch);

  // Environment steps since the pool was made.
  int64_t step_count() const { return step_count_; }
  // How its episodes ended.
  const RecentEpisodes& episodes() const { return episodes_; }

 private:
  // Of the game that an environment plays, in games_.
  size_t GameIndexOf(int32_t environment) const;
  void AddSteps(Part part, absl::Span<const Reset> resets);

  const int32_t first_env_;
  std::vector<GameMetrics*> games_;  // in the order of PoolOptions::games
  std::vector<int64_t> game_steps_;  // of the part that is counted, by game
  std::atomic<int64_t> step_count_ = 0;
  RecentEpisodes episodes_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_POOL_COUNTS_H_
