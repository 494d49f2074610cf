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
#include "server/cluster/node_status.h"
#include "server/cluster/topics.h"

namespace procgen {

// This node in a domain of Cyclone DDS: what it writes to the topics of topics.idl, and what it
// reads of the others. Gone with this, for the others, too.
// Threads: any method from any thread, but ReadNodes from one at a time.
class Participant {
 public:
  // `peer_addresses`: where the peers of `options` are. Errors: FAILED_PRECONDITION, with what
  // Cyclone DDS said.
  static absl::StatusOr<std::unique_ptr<Participant>> Create(
      const ClusterOptions& options, const std::vector<std::string>& peer_addresses);

  absl::Status Write(const NodeStatus& status) const;

  // What is written by who is alive, this node too; in no order.
  std::vector<NodeStatus> ReadNodes();

  // Waits until there may be something else to read, or somebody wakes it, or `timeout` is over.
  void Wait(absl::Duration timeout) const;
  void Wake() const;

 private:
  Participant() = default;

  absl::Status CreateDomain(const ClusterOptions& options,
                            const std::vector<std::string>& peer_addresses);
  absl::Status CreateTopics(const ClusterOptions& options);
  absl::Status CreateWaiting();

  DdsEntity domain_;
  DdsEntity participant_;
  DdsEntity publisher_;
  DdsEntity subscriber_;
  DdsTopic<procgen_topics_NodeStatus> nodes_;
  DdsTopic<procgen_topics_NodeRates> rates_;
  DdsEntity wake_;
  DdsEntity unread_nodes_;
  DdsEntity waiting_;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_PARTICIPANT_H_
