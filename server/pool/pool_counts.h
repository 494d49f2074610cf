#ifndef SERVER_POOL_POOL_COUNTS_H_
#define SERVER_POOL_POOL_COUNTS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/metrics/metrics.h"
#include "server/pool/episodes/episode_log.h"
#include "server/pool/episodes/recent_episodes.h"
#include "server/pool/quota/byte_budget.h"
#include "server/pool/request.h"

namespace procgen {

// Counts a pool's steps and the episodes that end in them, for the pool and by game.
// Threads: one call at a time; const methods from any thread.
class PoolCounts {
 public:
  // `metrics` and `episode_bytes` must outlive this.
  PoolCounts(const PoolOptions& options, Metrics* metrics, ByteBudget* episode_bytes);

  // Counts the steps in `batch`, except those of `input.resets`, which began an episode instead.
  // Returns the number of steps. `batch`: as BatchNumbers provides it. `log`: has the steps, for
  // recordings of the episodes; null: there are none.
  int64_t Add(const StepInput& input, const Batch& batch, const EpisodeLog* log);

  // Environment steps since the pool was made.
  int64_t step_count() const { return step_count_; }
  // Its episodes.
  const RecentEpisodes& episodes() const { return episodes_; }

 private:
  // Index in games_ of the environment's game.
  size_t GameIndexOf(int32_t environment) const;
  void AddSteps(const StepInput& input);

  const int32_t first_env_;
  std::vector<GameMetrics> games_;   // in the order of PoolOptions::games
  std::vector<int64_t> game_steps_;  // of the current step, by game
  std::atomic<int64_t> step_count_ = 0;
  RecentEpisodes episodes_;
};

}  // namespace procgen

#endif  // SERVER_POOL_POOL_COUNTS_H_
