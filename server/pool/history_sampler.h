#ifndef SERVER_POOL_HISTORY_SAMPLER_H_
#define SERVER_POOL_HISTORY_SAMPLER_H_

#include <functional>
#include <memory>
#include <vector>

#include "absl/time/time.h"
#include "server/concurrency/deadline_timer.h"

namespace procgen {

class PoolSession;

// Adds a row to the history of each pool every second, on one thread.
class HistorySampler {
 public:
  // Memory of the rows of all pools, in equal shares: 1,100 pools keep their full history of a day,
  // 16,384 a sixteenth of it.
  static constexpr int64_t kBytesMax = 128 << 20;

  // `list_pools` is called until the destructor returns.
  explicit HistorySampler(std::function<std::vector<std::shared_ptr<PoolSession>>()> list_pools);

 private:
  absl::Time OnTimer(absl::Time now);

  const std::function<std::vector<std::shared_ptr<PoolSession>>()> list_pools_;
  DeadlineTimer timer_;  // last: its thread uses the members before it
};

}  // namespace procgen

#endif  // SERVER_POOL_HISTORY_SAMPLER_H_
