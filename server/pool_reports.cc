#include "server/pool_reports.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <string>

#include "absl/time/time.h"
#include "server/pool/pool_session.h"
#include "server/wire/convert_pool.h"

namespace procgen {
namespace {

const std::string& GameOf(const PoolOptions& options, int32_t environment) {
  return options.games[(static_cast<size_t>(options.first_env) + static_cast<size_t>(environment)) %
                       options.games.size()];
}

// Mean return by game; empty for pools with one game. Covers as many episodes of each game as the
// pool's statistics do.
std::vector<web::GameReturn> GameReturnsOf(const PoolSession& pool) {
  struct Sum {
    double sum = 0;
    size_t count = 0;
  };
  std::map<std::string, Sum> sums;
  for (const std::string& game : pool.options().games) {
    sums[game];
  }
  std::vector<web::GameReturn> returns;
  if (sums.size() < 2) {
    return returns;
  }
  const RecentEpisodes::List list = pool.recent_episodes().ReadList(0);
  // NOLINTNEXTLINE(modernize-loop-convert): clang 14 cannot compile libstdc++'s reversed views
  for (auto episode = list.episodes.rbegin(); episode != list.episodes.rend(); ++episode) {
    Sum& sum = sums[GameOf(pool.options(), episode->environment)];
    if (sum.count < RecentEpisodes::kRecentCount) {
      sum.sum += static_cast<double>(episode->total_reward);
      ++sum.count;
    }
  }
  for (const auto& [game, sum] : sums) {
    returns.push_back({game, sum.count == 0
                                 ? std::numeric_limits<float>::quiet_NaN()
                                 : static_cast<float>(sum.sum / static_cast<double>(sum.count))});
  }
  return returns;
}

// The pool of an owner; null if there is none.
std::shared_ptr<PoolSession> FindPool(const Server& server, const std::string& owner,
                                      const std::string& name) {
  for (std::shared_ptr<PoolSession>& pool : server.ListAllPools()) {
    if (pool->owner() == owner && pool->name() == name) {
      return pool;
    }
  }
  return nullptr;
}

// A pool may be deleted while a page pauses it.
class PauseOfPool final : public web::PoolPause {
 public:
  explicit PauseOfPool(const std::shared_ptr<PoolSession>& pool) : pool_(pool) { pool->Pause(); }
  ~PauseOfPool() override {
    if (const std::shared_ptr<PoolSession> pool = pool_.lock(); pool != nullptr) {
      pool->EndPause();
    }
  }
  PauseOfPool(const PauseOfPool&) = delete;
  PauseOfPool& operator=(const PauseOfPool&) = delete;

  void Step() override {
    if (const std::shared_ptr<PoolSession> pool = pool_.lock(); pool != nullptr) {
      pool->StepPaused();
    }
  }

 private:
  const std::weak_ptr<PoolSession> pool_;
};

double SecondsOf(absl::Time time) { return absl::ToDoubleSeconds(time - absl::UnixEpoch()); }

}  // namespace

std::vector<web::PoolReport> ReportPools(const Server& server) {
  std::vector<web::PoolReport> reports;
  for (const std::shared_ptr<PoolSession>& pool : server.ListAllPools()) {
    const RecentEpisodes::ReturnSpread spread = pool->recent_episodes().ReadReturnSpread();
    reports.push_back({.pool = PoolMessageOf(*pool),
                       .return_min = spread.min,
                       .return_max = spread.max,
                       .return_deviation = spread.deviation,
                       .game_returns = GameReturnsOf(*pool),
                       .paused = pool->paused()});
  }
  return reports;
}

web::EpisodeList ReportEpisodes(const Server& server, const std::string& owner,
                                const std::string& name, int64_t after) {
  web::EpisodeList report;
  const std::shared_ptr<PoolSession> pool = FindPool(server, owner, name);
  if (pool == nullptr) {
    return report;
  }
  const RecentEpisodes::List list = pool->recent_episodes().ReadList(after);
  report.count = list.count;
  report.recorded_count = list.recorded_count;
  for (const EndedEpisode& episode : list.episodes) {
    report.episodes.push_back({.environment = episode.environment,
                               .level_seed = episode.level_seed,
                               .total_reward = episode.total_reward,
                               .length = episode.length,
                               .is_truncated = episode.is_truncated,
                               .level_complete = episode.level_complete,
                               .fingerprint = episode.fingerprint,
                               .end_time_s = SecondsOf(episode.end_time)});
  }
  return report;
}

std::unique_ptr<web::PoolPause> PausePool(const Server& server, const std::string& owner,
                                          const std::string& name) {
  const std::shared_ptr<PoolSession> pool = FindPool(server, owner, name);
  return pool == nullptr ? nullptr : std::make_unique<PauseOfPool>(pool);
}

}  // namespace procgen
