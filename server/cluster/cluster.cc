#include "server/cluster/cluster.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <thread>
#include <tuple>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "server/cluster/dds_log.h"
#include "server/cluster/domain_config.h"
#include "server/cluster/participant.h"

namespace procgen {
namespace {

// How soon what ends without a word (a lifespan, a rate) is noticed.
constexpr absl::Duration kLookInterval = absl::Milliseconds(200);

std::vector<std::string> ResolvePeers(const ClusterOptions& options) {
  std::vector<std::string> all;
  for (const std::string& peer : options.peers) {
    const std::vector<std::string> addresses = ResolveHost(peer);
    if (addresses.empty()) {
      LogOfCluster(false, absl::StrCat("peer ", peer, " has no address"));
    }
    all.insert(all.end(), addresses.begin(), addresses.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

class DdsCluster final : public Cluster {
 public:
  DdsCluster(std::string node_id, std::unique_ptr<Participant> participant)
      : node_id_(std::move(node_id)),
        participant_(std::move(participant)),
        thread_([this] { LookUntilStopped(); }) {}

  ~DdsCluster() override {
    stops_ = true;
    participant_->Wake();
    thread_.join();
  }

  const std::string& node_id() const override { return node_id_; }

  void Publish(NodeStatus status) override {
    status.node_id = node_id_;
    {
      absl::MutexLock lock(&mutex_);
      own_ = {status};
    }
    Report(participant_->Write(status));
    participant_->Wake();
  }

  std::vector<NodeStatus> Nodes() const override {
    absl::MutexLock lock(&mutex_);
    return NodesLocked();
  }

  void PublishPlacement(PoolPlacement placement) override {
    placement.fleet_id = node_id_;
    Report(participant_->Write(placement));
  }

  void WithdrawPlacement(const std::string& pool, int32_t shard) override {
    PoolPlacement key;
    key.fleet_id = node_id_;
    key.pool = pool;
    key.shard = shard;
    Report(participant_->Withdraw(key));
  }

  std::vector<PoolPlacement> Placements() const override {
    absl::MutexLock lock(&mutex_);
    return placements_;
  }

  Subscription Subscribe(absl::AnyInvocable<void()> changed) override {
    absl::MutexLock lock(&telling_);
    const int64_t number = ++last_subscription_;
    subscribers_.emplace(number, std::move(changed));
    return Subscription([this, number] {
      absl::MutexLock end_lock(&telling_);
      subscribers_.erase(number);
    });
  }

 private:
  static void Report(const absl::Status& status) {
    if (!status.ok()) {
      LogOfCluster(true, absl::StrCat("cannot tell the cluster: ", status.message()));
    }
  }

  std::vector<NodeStatus> NodesLocked() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    std::vector<NodeStatus> nodes = others_;
    nodes.insert(nodes.end(), own_.begin(), own_.end());
    std::sort(nodes.begin(), nodes.end(),
              [](const NodeStatus& a, const NodeStatus& b) { return a.node_id < b.node_id; });
    return nodes;
  }

  void LookUntilStopped() {
    std::vector<NodeStatus> told_nodes;
    std::vector<PoolPlacement> told_placements;
    while (!stops_) {
      participant_->Wait(kLookInterval);
      Look();
      std::vector<NodeStatus> nodes = Nodes();
      std::vector<PoolPlacement> placements = Placements();
      if (nodes == told_nodes && placements == told_placements) {
        continue;
      }
      told_nodes = std::move(nodes);
      told_placements = std::move(placements);
      absl::MutexLock lock(&telling_);
      for (auto& [number, changed] : subscribers_) {
        changed();
      }
    }
  }

  // Reads how the others are.
  void Look() {
    std::vector<NodeStatus> others = participant_->ReadNodes();
    // How this node is it knows best.
    others.erase(
        std::remove_if(others.begin(), others.end(),
                       [this](const NodeStatus& node) { return node.node_id == node_id_; }),
        others.end());
    std::vector<PoolPlacement> placements = participant_->ReadPlacements();
    const auto key = [](const PoolPlacement& placement) {
      return std::tie(placement.fleet_id, placement.pool, placement.shard);
    };
    std::sort(placements.begin(), placements.end(),
              [&key](const PoolPlacement& a, const PoolPlacement& b) { return key(a) < key(b); });
    absl::MutexLock lock(&mutex_);
    others_ = std::move(others);
    placements_ = std::move(placements);
  }

  const std::string node_id_;
  const std::unique_ptr<Participant> participant_;
  std::atomic<bool> stops_ = false;

  mutable absl::Mutex mutex_;
  std::vector<NodeStatus> own_ ABSL_GUARDED_BY(mutex_);  // one, or none yet
  std::vector<NodeStatus> others_ ABSL_GUARDED_BY(mutex_);
  std::vector<PoolPlacement> placements_ ABSL_GUARDED_BY(mutex_);

  absl::Mutex telling_;  // held while subscribers are told; before mutex_
  std::map<int64_t, absl::AnyInvocable<void()>> subscribers_ ABSL_GUARDED_BY(telling_);
  int64_t last_subscription_ ABSL_GUARDED_BY(telling_) = 0;

  std::thread thread_;  // last: it uses all of the above
};

}  // namespace

absl::StatusOr<std::unique_ptr<Cluster>> Cluster::Join(const ClusterOptions& options) {
  if (absl::Status status = CheckClusterOptions(options); !status.ok()) {
    return status;
  }
  absl::StatusOr<std::unique_ptr<Participant>> participant =
      Participant::Create(options, ResolvePeers(options));
  if (!participant.ok()) {
    return participant.status();
  }
  return std::make_unique<DdsCluster>(options.node_id, *std::move(participant));
}

}  // namespace procgen
