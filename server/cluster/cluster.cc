#include "server/cluster/cluster.h"

#include <algorithm>
#include <memory>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "server/cluster/dds_log.h"
#include "server/cluster/participant.h"
#include "server/cluster/timing.h"
#include "server/concurrency/steady_time.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

// Returns the addresses of all peers, sorted. `complains`: log peers without an address.
std::vector<std::string> ResolvePeers(const ClusterOptions& options, const HostResolver& resolve,
                                      bool complains) {
  std::vector<std::string> all;
  for (const std::string& peer : options.peers) {
    const std::vector<std::string> addresses = resolve(peer);
    if (addresses.empty() && complains) {
      LogOfCluster(LogLevel::kWarning, absl::StrCat("peer ", peer, " has no address, yet"));
    }
    all.insert(all.end(), addresses.begin(), addresses.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

void Report(const absl::Status& status) {
  if (!status.ok()) {
    LogOfCluster(LogLevel::kError, absl::StrCat("cannot tell the cluster: ", status.message()));
  }
}

// Whether the other nodes have to hear of a change at once; a new rate can wait.
bool IsNews(const NodeStatus& before, NodeStatus status) {
  status.steps_per_second = before.steps_per_second;
  return status != before;
}

class DdsCluster final : public Cluster {
 public:
  DdsCluster(ClusterOptions options, HostResolver resolve, std::vector<std::string> peer_addresses,
             std::shared_ptr<Participant> participant)
      : options_(std::move(options)),
        resolve_(std::move(resolve)),
        peer_addresses_(std::move(peer_addresses)),
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
      absl::MutexLock lock(&mutex_);
      published_ = SteadyNow();
      const bool is_news = own_.empty() || IsNews(own_.front(), status);
      own_ = {std::move(status)};
      if (is_news) {
        Send();
      }
    }
  }

  std::vector<NodeStatus> Nodes() const override {
    absl::MutexLock lock(&mutex_);
    std::vector<NodeStatus> nodes = others_;
    nodes.insert(nodes.end(), own_.begin(), own_.end());
    std::sort(nodes.begin(), nodes.end(),
              [](const NodeStatus& a, const NodeStatus& b) { return a.node_id < b.node_id; });
    return nodes;
  }

 private:
  std::shared_ptr<Participant> participant() const {
    absl::MutexLock lock(&mutex_);
    return participant_;
  }

  bool Stops() const { return stopped_.HasBeenNotified(); }

  void WatchUntilStopped() {
    while (!Stops()) {
      RefreshNodes();
      // Samples that arrive meanwhile are read together.
      stopped_.WaitWithTimeout(kRefreshIntervalMin);
    }
  }

  // Waits for new samples, at most kRefreshInterval; then reads those of the other nodes, and
  // repeats that of this one if it is due.
  void RefreshNodes() {
    const std::shared_ptr<Participant> participant = this->participant();
    participant->Wait(kRefreshInterval);
    std::vector<NodeStatus> nodes = participant->ReadNodes();
    std::erase_if(nodes, [&](const NodeStatus& node) { return node.node_id == node_id(); });
    const absl::Time now = SteadyNow();
    absl::MutexLock lock(&mutex_);
    if (participant == participant_) {
      others_ = std::move(nodes);
    }
    const absl::Duration interval =
        std::max(kStatusIntervalMin, absl::Seconds(others_.size()) / kStatusesPerSecondMax);
    if (now < published_ + kPublishTimeout && now >= sent_time_ + interval) {
      Send();
    }
  }

  // Sends the status of this node to the others.
  void Send() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    Report(participant_->Write(own_.front()));
    sent_time_ = SteadyNow();
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
        LogOfCluster(LogLevel::kError, next.status().message());
        continue;
      }
      TakeOver(*std::move(next));
      peer_addresses_ = std::move(addresses);
    }
  }

  // This node loses no other, since the second participant has discovered all that the first knows.
  void TakeOver(std::shared_ptr<Participant> next) {
    const absl::Time end = SteadyNow() + kTakeOverTimeout;
    while (next->ReadNodes().size() < Nodes().size() && SteadyNow() < end && !Stops()) {
      next->Wait(kRefreshInterval);
    }
    {
      absl::MutexLock lock(&mutex_);
      participant_.swap(next);
    }
    // The others receive a status of the second before the first leaves.
    stopped_.WaitWithTimeout(kTakeOverTimeout);
  }

  const ClusterOptions options_;
  const HostResolver resolve_;
  SteadyNotification stopped_;
  std::vector<std::string> peer_addresses_;  // used by the resolving thread only

  mutable absl::Mutex mutex_;
  // shared with its current users
  std::shared_ptr<Participant> participant_ ABSL_GUARDED_BY(mutex_);
  // this node; empty before Publish
  std::vector<NodeStatus> own_ ABSL_GUARDED_BY(mutex_);
  absl::Time published_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time sent_time_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  std::vector<NodeStatus> others_ ABSL_GUARDED_BY(mutex_);

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
