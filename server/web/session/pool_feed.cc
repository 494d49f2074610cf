#include "server/web/session/pool_feed.h"

#include <utility>

#include "absl/time/clock.h"
#include "server/web/session/convert_json.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

constexpr absl::Duration kInterval = absl::Seconds(1);

double NowSeconds() { return absl::ToDoubleSeconds(absl::Now() - absl::UnixEpoch()); }

}  // namespace

PoolFeed::PoolFeed(std::function<std::vector<v1::Pool>()> list_pools)
    : list_pools_(std::move(list_pools)), thread_([this] { Run(); }) {}

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
  absl::MutexLock telling(&telling_);
  absl::MutexLock lock(&mutex_);
  followers_.erase(follower);
}

Json PoolFeed::HistoryOf(const v1::Pool& pool) {
  absl::MutexLock lock(&mutex_);
  return history_.RowsOf(pool);
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
    if (!only_new) {
      const std::vector<v1::Pool> pools = list_pools_();
      absl::MutexLock lock(&mutex_);
      history_.Add(NowSeconds(), pools);
      next = std::max(next + kInterval, SteadyNow());
    }
    TellFollowers(only_new);
  }
}

void PoolFeed::TellFollowers(bool only_new) {
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
    const absl::StatusOr<Json> event = EventFor(client.get());
    absl::MutexLock telling(&telling_);
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

absl::StatusOr<Json> PoolFeed::EventFor(procgen_client::Client* client) {
  const absl::StatusOr<std::vector<v1::Pool>> pools = client->ListPools();
  const absl::StatusOr<v1::Load> load = client->GetLoad();
  const absl::StatusOr<v1::ListNodesResponse> nodes = client->ListNodes();
  for (const absl::Status& status : {pools.status(), load.status(), nodes.status()}) {
    if (!status.ok()) {
      return status;
    }
  }
  double steps_per_second = 0;
  for (const v1::Node& node : nodes->nodes()) {
    if (node.name() == nodes->local_node()) {
      steps_per_second = node.steps_per_second();
    }
  }
  Json list = Json::array();
  absl::MutexLock lock(&mutex_);
  for (const v1::Pool& pool : *pools) {
    list.emplace_back(PoolJson(pool))["steps_per_second"] = history_.StepsPerSecond(pool);
  }
  return Json{{"event", "pools"},
              {"time_s", NowSeconds()},
              {"server", {{"load", LoadJson(*load, steps_per_second)}}},
              {"pools", std::move(list)},
              {"nodes", NodesJson(*nodes)}};
}

}  // namespace procgen::web
