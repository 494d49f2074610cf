#ifndef SERVER_WEB_SESSION_POOL_REPORT_H_
#define SERVER_WEB_SESSION_POOL_REPORT_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "procgen/v1/pools.pb.h"

namespace procgen::web {

// The mean return of a pool's last episodes of one game.
struct GameReturn {
  std::string game;
  float mean_return = 0;  // NaN: no episode yet
};

// The state of a pool, and statistics of its episodes that the API does not have.
struct PoolReport {
  procgen::v1::Pool pool;
  // Of the episodes that pool.mean_episode_return covers; 0 if none.
  float return_min = 0;
  float return_max = 0;
  float return_deviation = 0;            // standard deviation
  std::vector<GameReturn> game_returns;  // one per game, if the pool has several
  bool paused = false;                   // by a page
};

// An episode that ended in a pool.
struct EndedEpisode {
  int32_t environment = 0;
  int32_t level_seed = 0;
  float total_reward = 0;
  int32_t length = 0;  // in steps
  bool is_truncated = false;
  bool level_complete = false;
  uint64_t fingerprint = 0;
  double end_time_s = 0;  // since 1970
};

// The last episodes of a pool, oldest first.
struct EpisodeList {
  int64_t count = 0;  // of all episodes of the pool
  std::vector<EndedEpisode> episodes;
  int64_t recorded_count = 0;  // number of last episodes that have a recording
};

// A pause of a pool: requests of its learner wait. The pause ends with this object.
class PoolPause {
 public:
  virtual ~PoolPause() = default;
  // Lets one more request pass.
  virtual void Step() = 0;
};

// Pauses a pool; null if there is no such pool. Does not check that a viewer may pause it.
using PausePool =
    std::function<std::unique_ptr<PoolPause>(const std::string& owner, const std::string& name)>;

// Returns the last episodes of a pool, without the first `after`. Does not check that a viewer may
// see the pool.
using ReportEpisodes =
    std::function<EpisodeList(const std::string& owner, const std::string& name, int64_t after)>;

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_POOL_REPORT_H_
