#include "server/pool/history_sampler.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "server/concurrency/steady_time.h"
#include "server/pool/history/pool_history.h"
#include "server/pool/pool_session.h"

namespace procgen {
namespace {

constexpr absl::Duration kInterval = absl::Seconds(1);

float SecondsOf(absl::Duration duration) {
  return static_cast<float>(absl::ToDoubleSeconds(duration));
}

PoolHistoryRow RowOf(const PoolSession& pool) {
  PoolHistoryRow row;
  row.time = absl::Now();
  row.step_count = pool.step_count();
  const RecentEpisodes::Summary episodes = pool.episodes();
  row.episode_count = episodes.count;
  if (episodes.count > 0) {
    const RecentEpisodes::ReturnSpread spread = pool.recent_episodes().ReadReturnSpread();
    row.mean_episode_return = episodes.mean_return;
    row.mean_episode_length = episodes.mean_length;
    row.min_episode_return = spread.min;
    row.max_episode_return = spread.max;
    row.episode_return_deviation = spread.deviation;
  }
  if (const RequestTimes::Summary times = pool.request_times(); times.count > 0) {
    row.request_duration_p50_s = SecondsOf(times.p50);
    row.request_duration_p99_s = SecondsOf(times.p99);
  }
  for (const GameReturn& game : pool.ReadGameReturns()) {
    row.game_returns.push_back(game.mean_return.value_or(PoolHistoryRow::kNone));
  }
  return row;
}

}  // namespace

HistorySampler::HistorySampler(
    std::function<std::vector<std::shared_ptr<PoolSession>>()> list_pools)
    : list_pools_(std::move(list_pools)),
      timer_(SteadyNow, [this](absl::Time now) { return OnTimer(now); }) {
  timer_.ArmBy(SteadyNow() + kInterval);
}

absl::Time HistorySampler::OnTimer(absl::Time now) {
  const std::vector<std::shared_ptr<PoolSession>> pools = list_pools_();
  const int64_t share = kBytesMax / std::max<int64_t>(1, static_cast<int64_t>(pools.size()));
  for (const std::shared_ptr<PoolSession>& pool : pools) {
    pool->history().Add(RowOf(*pool), share);
  }
  return std::max(now + kInterval, SteadyNow());
}

}  // namespace procgen
