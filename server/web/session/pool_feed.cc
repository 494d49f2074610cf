#include "server/web/session/pool_feed.h"

#include <set>
#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "server/web/play/page_pool.h"
#include "server/web/session/convert_json.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

constexpr absl::Duration kInterval = absl::Seconds(1);

double NowSeconds() { return absl::ToDoubleSeconds(absl::Now() - absl::UnixEpoch()); }

}  // namespace

PoolFeed::PoolFeed(std::function<std::vector<PoolReport>()> report_pools)
    : report_pools_(std::move(report_pools)), thread_([this] { Run(); }) {}

PoolFeed::~PoolFeed() {
  {
    absl::MutexLock lock(&mutex_);
    is_stopping_ = true;
    changed_.NotifyAll();
  }
  thread_.join();
}

void PoolFeed::Follow(const void* follower, const std::string& token,
                      std::shared_ptr<procgen_client::Client> client, OnEvent on_event) {
  absl::MutexLock lock(&mutex_);
  followers_[follower] = {token, std::move(client), std::move(on_event)};
  has_new_ = true;
  changed_.NotifyAll();
}

void PoolFeed::Unfollow(const void* follower) {
  absl::MutexLock telling(&notify_mutex_);
  absl::MutexLock lock(&mutex_);
  followers_.erase(follower);
}

Json PoolFeed::HistoryOf(const v1::Pool& pool, int32_t span_s) {
  absl::MutexLock lock(&mutex_);
  return history_.RowsOf(pool, span_s);
}

Json PoolFeed::ReturnsOf(const v1::Pool& pool, size_t count) {
  absl::MutexLock lock(&mutex_);
  return history_.ReturnsOf(pool, count);
}

void PoolFeed::Run() {
  absl::Time next = SteadyNow();
  while (true) {
    bool only_new = false;
    {
      absl::MutexLock lock(&mutex_);
      const auto is_due = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return is_stopping_ || has_new_;
      };
      only_new = changed_.AwaitUntil(&mutex_, next, is_due);
      if (is_stopping_) {
        return;
      }
      has_new_ = false;
    }
    const std::vector<PoolReport> pools = report_pools_();
    if (!only_new) {
      absl::MutexLock lock(&mutex_);
      history_.Add(NowSeconds(), pools);
      next = std::max(next + kInterval, SteadyNow());
    }
    TellFollowers(only_new, pools);
  }
}

void PoolFeed::TellFollowers(bool only_new, const std::vector<PoolReport>& all_pools) {
  std::map<std::string, std::shared_ptr<procgen_client::Client>> clients;
  {
    absl::MutexLock lock(&mutex_);
    for (auto& [key, follower] : followers_) {
      if (follower.is_new || !only_new) {
        clients[follower.token] = follower.client;
      }
    }
  }
  for (const auto& [token, client] : clients) {
    const absl::StatusOr<Json> event = EventFor(client.get(), all_pools);
    absl::MutexLock telling(&notify_mutex_);
    std::vector<OnEvent> callbacks;
    {
      absl::MutexLock lock(&mutex_);
      for (auto follower = followers_.begin(); follower != followers_.end();) {
        if (follower->second.token == token && (follower->second.is_new || !only_new)) {
          follower->second.is_new = false;
          callbacks.push_back(follower->second.on_event);
          if (!event.ok()) {
            follower = followers_.erase(follower);
            continue;
          }
        }
        ++follower;
      }
    }
    for (const OnEvent& on_event : callbacks) {
      on_event(event);
    }
  }
}

absl::StatusOr<Json> PoolFeed::EventFor(procgen_client::Client* client,
                                        const std::vector<PoolReport>& all_pools) {
  const absl::StatusOr<std::vector<v1::Pool>> pools = client->ListPools();
  const absl::StatusOr<v1::Load> load = client->GetLoad();
  const absl::StatusOr<v1::ListNodesResponse> nodes = client->ListNodes();
  for (const absl::Status& status : {pools.status(), load.status(), nodes.status()}) {
    if (!status.ok()) {
      return status;
    }
  }
  absl::MutexLock lock(&mutex_);
  double steps_per_second = 0;
  std::set<std::pair<std::string, std::string>> paused;  // owner and name
  for (const PoolReport& report : all_pools) {
    const Json newest = history_.NewestOf(report.pool);
    if (KindOfPool(report.pool.name()) == "pool" && !newest["steps_per_second"].is_null()) {
      steps_per_second += newest["steps_per_second"].get<double>();
    }
    if (report.paused) {
      paused.emplace(report.pool.owner(), report.pool.name());
    }
  }
  Json list = Json::array();
  for (const v1::Pool& pool : *pools) {
    Json& listed = list.emplace_back(PoolJson(pool));
    listed.update(history_.NewestOf(pool));
    listed["paused"] = paused.contains({pool.owner(), pool.name()});
  }
  return Json{{"event", "pools"},
              {"time_s", NowSeconds()},
              {"server", {{"load", LoadJson(*load, all_pools, steps_per_second)}}},
              {"pools", std::move(list)},
              {"nodes", NodesJson(*nodes)}};
}

}  // namespace procgen::web
