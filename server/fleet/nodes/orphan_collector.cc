#include "server/fleet/nodes/orphan_collector.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "server/fleet/timing.h"
#include "server/logging/event_log.h"

namespace procgen {
OrphanCollector::OrphanCollector(std::string prefix, FleetNodes* nodes)
    : prefix_(std::move(prefix)), nodes_(nodes), thread_([this] { Run(); }) {}

OrphanCollector::~OrphanCollector() {
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
    wakes_.NotifyAll();
  }
  thread_.join();
}

void OrphanCollector::BeginUse(const std::string& pool_id) {
  absl::MutexLock lock(&mutex_);
  used_.insert(pool_id);
}

void OrphanCollector::EndUse(const std::string& pool_id, const std::string& node_id) {
  absl::MutexLock lock(&mutex_);
  used_.erase(pool_id);
  pending_.insert({node_id, 0});
  changed_ = true;
  wakes_.NotifyAll();
}

void OrphanCollector::OnNodesChanged() {
  absl::MutexLock lock(&mutex_);
  changed_ = true;
  wakes_.NotifyAll();
}

std::vector<std::string> OrphanCollector::PendingNodes() {
  std::vector<std::pair<int32_t, std::string>> by_failures;
  by_failures.reserve(pending_.size());
  for (const auto& [node, failures] : pending_) {
    by_failures.emplace_back(failures, node);
  }
  std::sort(by_failures.begin(), by_failures.end());
  std::vector<std::string> todo;
  todo.reserve(by_failures.size());
  for (auto& [failures, node] : by_failures) {
    todo.push_back(std::move(node));
  }
  return todo;
}

void OrphanCollector::Run() {
  bool stops = false;
  while (!stops) {
    {
      absl::MutexLock lock(&mutex_);
      wakes_.AwaitUntil(
          &mutex_, pending_.empty() ? absl::InfiniteFuture() : SteadyNow() + kOrphanRetryInterval,
          [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stops_ || changed_; });
      changed_ = false;
      stops = stops_;
    }
    const std::vector<std::string> nodes = nodes_->Present();
    std::vector<std::string> todo;
    {
      absl::MutexLock lock(&mutex_);
      for (const std::string& node : nodes) {
        if (!present_.contains(node)) {
          pending_.insert({node, 0});
        }
      }
      std::set<std::string> present = {nodes.begin(), nodes.end()};
      // Nodes that are gone are checked when they return.
      std::erase_if(pending_,
                    [&present](const auto& node) { return !present.contains(node.first); });
      present_ = std::move(present);
      todo = PendingNodes();
    }
    for (const std::string& node : todo) {
      if (stops && !nodes_->IsConnected(node)) {
        continue;  // not worth a wait for a connection
      }
      int32_t failures = 0;
      {
        absl::MutexLock lock(&mutex_);
        if (!stops && (stops_ || changed_)) {
          break;  // new nodes go first
        }
        failures = pending_.extract(node).mapped();
      }
      if (!CollectFrom(node)) {
        absl::MutexLock lock(&mutex_);
        pending_[node] = failures + 1;
      }
    }
  }
}

bool OrphanCollector::CollectFrom(const std::string& node_id) {
  const absl::StatusOr<std::shared_ptr<NodeClient>> node = nodes_->Connect(node_id);
  if (!node.ok()) {
    return false;
  }
  const absl::StatusOr<std::vector<v1::Pool>> pools = (*node)->client->ListPools();
  if (!pools.ok()) {
    return false;
  }
  bool all_deleted = true;
  for (const v1::Pool& pool : *pools) {
    const std::string& name = pool.name();
    bool is_ours = false;
    if (absl::StartsWith(name, absl::StrCat("pools/", prefix_))) {
      absl::MutexLock lock(&mutex_);
      is_ours = !used_.contains(name.substr(name.find('/') + 1));
    }
    if (!is_ours) {
      continue;
    }
    const absl::Status deleted = (*node)->client->DeletePool(name);
    all_deleted = all_deleted && (deleted.ok() || absl::IsNotFound(deleted));
    LogEvent(LogLevel::kDebug, "shard_removed", {{"node", node_id}, {"shard", name}});
  }
  return all_deleted;
}

}  // namespace procgen
