#ifndef SERVER_CLUSTER_PARTICIPANT_H_
#define SERVER_CLUSTER_PARTICIPANT_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/cluster/cluster_options.h"
#include "server/cluster/dds_entity.h"
#include "server/cluster/dds_topic.h"
#include "server/cluster/failure_detector.h"
#include "server/cluster/topics.h"

namespace procgen {

// This node in a domain of Cyclone DDS: writes its samples to the topics of topics.idl and reads
// those of the others. Destruction leaves the domain.
// Threads: any method from any thread, but those that read or
// monitor from one at a time.
class Participant {
 public:
  // `peer_addresses`: of the peers in `options`. Errors: FAILED_PRECONDITION, with the message of
  // Cyclone DDS.
  static absl::StatusOr<std::unique_ptr<Participant>> Create(
      const ClusterOptions& options, const std::vector<std::string>& peer_addresses);

  absl::Status Write(const NodeReport& report) const;
  absl::Status WriteHeartbeat() const;

  // Returns the reports of all nodes that have not left, including this one, unordered.
  std::vector<NodeReport> ReadNodes();

  // Sets the ids of the nodes whose heartbeats are received.
  absl::Status Monitor(const std::vector<std::string>& node_ids);
  // Returns the ids of nodes of which heartbeats arrived since the last call.
  std::vector<std::string> TakeHeartbeats();

  // Waits until there may be something new to read, a wakeup, or the timeout.
  void Wait(absl::Duration timeout) const;
  void Wake() const;

 private:
  explicit Participant(const ClusterOptions& options)
      : cluster_(options.name), node_id_(options.node_id) {}

  absl::Status CreateDomain(const ClusterOptions& options,
                            const std::vector<std::string>& peer_addresses);
  absl::Status CreateTopics();
  absl::Status CreateWaiting();
  // The partition of a node's heartbeats.
  std::string HeartbeatPartition(const std::string& node_id) const;

  const std::string cluster_;
  const std::string node_id_;
  DdsEntity domain_;
  DdsEntity participant_;
  DdsEntity publisher_;
  DdsEntity subscriber_;
  DdsTopic<procgen_topics_NodeStatus> nodes_;
  DdsEntity heartbeat_publisher_;
  DdsEntity heartbeat_subscriber_;  // none before Monitor
  DdsTopic<procgen_topics_NodeHeartbeat> heartbeats_;
  std::vector<std::string> monitored_;
  DdsEntity wake_;
  DdsEntity unread_nodes_;
  DdsEntity waiting_;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_PARTICIPANT_H_
