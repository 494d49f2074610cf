#include "server/cluster/cluster.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "server/cluster/dds_log.h"
#include "server/cluster/failure_detector.h"
#include "server/cluster/participant.h"
#include "server/cluster/subscribers.h"
#include "server/cluster/timing.h"
#include "server/concurrency/steady_time.h"

namespace procgen {
namespace {

// Relative change of a node's rate that is not published.
constexpr double kRateTolerance = 0.1;

// Returns the addresses of all peers, sorted. `complains`: log peers without an address.
std::vector<std::string> ResolvePeers(const ClusterOptions& options, const HostResolver& resolve,
                                      bool complains) {
  std::vector<std::string> all;
  for (const std::string& peer : options.peers) {
    const std::vector<std::string> addresses = resolve(peer);
    if (addresses.empty() && complains) {
      LogOfCluster(false, absl::StrCat("peer ", peer, " has no address, yet"));
    }
    all.insert(all.end(), addresses.begin(), addresses.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

void Report(const absl::Status& status) {
  if (!status.ok()) {
    LogOfCluster(true, absl::StrCat("cannot tell the cluster: ", status.message()));
  }
}

// Whether the other nodes have to hear of a change. `sends_rate`: also of one of the rate alone.
bool DiffersFrom(const NodeStatus& sent, NodeStatus status, bool sends_rate) {
  const double change = std::abs(status.steps_per_second - sent.steps_per_second);
  if (!sends_rate || change <= kRateTolerance * sent.steps_per_second) {
    status.steps_per_second = sent.steps_per_second;
  }
  return status != sent;
}

class DdsCluster final : public Cluster {
 public:
  DdsCluster(ClusterOptions options, HostResolver resolve, std::vector<std::string> peer_addresses,
             std::shared_ptr<Participant> participant)
      : options_(std::move(options)),
        resolve_(std::move(resolve)),
        peer_addresses_(std::move(peer_addresses)),
        detector_(options_.node_id),
        participant_(std::move(participant)),
        watching_([this] { WatchUntilStopped(); }) {
    if (!options_.peers.empty()) {
      resolving_ = std::thread([this] { ResolveUntilStopped(); });
    }
  }

  ~DdsCluster() override {
    stopped_.Notify();
    participant()->Wake();
    watching_.join();
    {
      absl::MutexLock lock(&mutex_);
      participant_ = nullptr;  // leaves now: the resolver may take long
    }
    if (resolving_.joinable()) {
      resolving_.join();
    }
  }

  const std::string& name() const override { return options_.name; }
  const std::string& node_id() const override { return options_.node_id; }

  void Publish(NodeStatus status) override {
    status.node_id = options_.node_id;
    {
      absl::MutexLock lock(&speaking_);
      published_ = SteadyNow();
      const bool sends_rate =
          published_ >= sent_time_ + absl::Seconds(detector_.others().size()) / kRatesPerSecondMax;
      const bool is_news = !sent_.has_value() || DiffersFrom(*sent_, status, sends_rate);
      {
        absl::MutexLock known(&mutex_);
        own_ = {std::move(status)};
      }
      if (is_news) {
        Send();
      }
    }
    participant()->Wake();
  }

  std::vector<NodeStatus> Nodes() const override {
    absl::MutexLock lock(&mutex_);
    std::vector<NodeStatus> nodes = others_;
    nodes.insert(nodes.end(), own_.begin(), own_.end());
    std::sort(nodes.begin(), nodes.end(),
              [](const NodeStatus& a, const NodeStatus& b) { return a.node_id < b.node_id; });
    return nodes;
  }

  Subscription Subscribe(absl::AnyInvocable<void()> changed) override {
    return subscribers_.Add(std::move(changed));
  }

 private:
  std::shared_ptr<Participant> participant() const {
    absl::MutexLock lock(&mutex_);
    return participant_;
  }

  bool Stops() const { return stopped_.HasBeenNotified(); }

  void WatchUntilStopped() {
    std::vector<NodeStatus> told_nodes;
    while (!Stops()) {
      RefreshNodes();
      std::vector<NodeStatus> nodes = Nodes();
      if (nodes == told_nodes) {
        stopped_.WaitWithTimeout(kRefreshIntervalMin);
        continue;
      }
      told_nodes = std::move(nodes);
      subscribers_.Notify();
      // Changes that arrive meanwhile are reported together.
      stopped_.WaitWithTimeout(kTellIntervalMin);
    }
  }

  // Waits for new samples, at most kRefreshInterval; then reads those of the other nodes and speaks
  // for this one.
  void RefreshNodes() {
    const std::shared_ptr<Participant> participant = this->participant();
    participant->Wait(std::min(kRefreshInterval, next_heartbeat_ - SteadyNow()));
    const std::vector<NodeReport> reports = participant->ReadNodes();
    const std::vector<std::string> heard = participant->TakeHeartbeats();
    const absl::Time now = SteadyNow();
    {
      absl::MutexLock lock(&speaking_);
      const bool is_alive = now < published_ + kPublishTimeout;
      for (const NodeReport& report : reports) {
        if (report.status.node_id == node_id() && report.status != sent_) {
          sent_.reset();  // another node has the same id, perhaps a predecessor: publish again
        }
      }
      const bool is_news = detector_.Update(now, reports, heard, is_alive);
      if (sent_.has_value() && is_news) {
        Send();
      }
      if (now >= next_heartbeat_) {
        next_heartbeat_ = now + kHeartbeatInterval;
        if (is_alive) {
          Report(participant->WriteHeartbeat());
        }
      }
      Report(participant->Monitor(detector_.monitored()));
      absl::MutexLock known(&mutex_);
      if (participant == participant_) {
        others_ = detector_.others();
      }
    }
  }

  // Publishes the status of this node.
  void Send() ABSL_EXCLUSIVE_LOCKS_REQUIRED(speaking_) {
    absl::MutexLock known(&mutex_);
    for (const NodeStatus& status : own_) {
      Report(participant_->Write({status, detector_.incarnation(), detector_.losses()}));
      sent_ = status;
      sent_time_ = SteadyNow();
    }
  }

  // Cyclone DDS takes the peers' addresses at startup only. If these change to include more than
  // the known nodes, a second participant starts with them and replaces the first.
  void ResolveUntilStopped() {
    while (!stopped_.WaitWithTimeout(kResolveInterval)) {
      std::vector<std::string> addresses = ResolvePeers(options_, resolve_, /*complains=*/false);
      if (addresses == peer_addresses_ || addresses.size() <= Nodes().size() || Stops()) {
        continue;
      }
      absl::StatusOr<std::shared_ptr<Participant>> next = Participant::Create(options_, addresses);
      if (!next.ok()) {
        LogOfCluster(true, next.status().message());
        continue;
      }
      TakeOver(*std::move(next));
      peer_addresses_ = std::move(addresses);
    }
  }

  // The other nodes see no interruption, since both participants write the same. This node loses
  // none, since the second participant has discovered all nodes that the first knows.
  void TakeOver(std::shared_ptr<Participant> next) {
    const absl::Time end = SteadyNow() + kTakeOverTimeout;
    while (next->ReadNodes().size() < Nodes().size() && SteadyNow() < end && !Stops()) {
      next->Wait(kRefreshInterval);
    }
    absl::MutexLock lock(&speaking_);
    {
      absl::MutexLock known(&mutex_);
      participant_.swap(next);
    }
    Send();
  }

  const ClusterOptions options_;
  const HostResolver resolve_;
  SteadyNotification stopped_;
  std::vector<std::string> peer_addresses_;  // used by the resolving thread only
  absl::Time next_heartbeat_ = SteadyNow();  // used by the watching thread only

  absl::Mutex speaking_;  // held while this node writes; before mutex_
  FailureDetector detector_ ABSL_GUARDED_BY(speaking_);
  // the status that the other nodes know; empty: they may know another
  std::optional<NodeStatus> sent_ ABSL_GUARDED_BY(speaking_);
  absl::Time sent_time_ ABSL_GUARDED_BY(speaking_) = absl::InfinitePast();
  absl::Time published_ ABSL_GUARDED_BY(speaking_) = absl::InfinitePast();

  mutable absl::Mutex mutex_;
  // shared with its current users
  std::shared_ptr<Participant> participant_ ABSL_GUARDED_BY(mutex_);
  // this node; empty before Publish
  std::vector<NodeStatus> own_ ABSL_GUARDED_BY(mutex_);
  std::vector<NodeStatus> others_ ABSL_GUARDED_BY(mutex_);
  Subscribers subscribers_;

  // Last: they use the members above.
  std::thread watching_;
  std::thread resolving_;  // only if there are peers
};

}  // namespace

absl::StatusOr<std::unique_ptr<Cluster>> Cluster::Join(const ClusterOptions& options,
                                                       HostResolver resolve) {
  if (absl::Status status = CheckClusterOptions(options); !status.ok()) {
    return status;
  }
  std::vector<std::string> addresses = ResolvePeers(options, resolve, /*complains=*/true);
  absl::StatusOr<std::shared_ptr<Participant>> participant =
      Participant::Create(options, addresses);
  if (!participant.ok()) {
    return participant.status();
  }
  return std::make_unique<DdsCluster>(options, std::move(resolve), std::move(addresses),
                                      *std::move(participant));
}

}  // namespace procgen
