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

// This node in a domain of Cyclone DDS: writes its samples to the topic of topics.idl and reads
// those of the others. Destruction leaves the domain.
// Threads: any method from any thread, but ReadNodes from one at a time.
class Participant {
 public:
  // `peer_addresses`: of the peers in `options`. Errors: FAILED_PRECONDITION; Cyclone DDS logs the
  // reason.
  static absl::StatusOr<std::unique_ptr<Participant>> Create(
      const ClusterOptions& options, const std::vector<std::string>& peer_addresses);

  absl::Status Write(const NodeStatus& status) const;

  // Returns the last status of all nodes, including this one, that have not left and wrote one
  // within kNodeLease; unordered.
  std::vector<NodeStatus> ReadNodes();

  // Waits until there may be something new to read, a wakeup, or the timeout.
  void Wait(absl::Duration timeout) const;
  void Wake() const;

 private:
  explicit Participant(const ClusterOptions& options) : cluster_(options.name) {}

  absl::Status CreateDomain(const ClusterOptions& options,
                            const std::vector<std::string>& peer_addresses);
  absl::Status CreateTopic();
  absl::Status CreateWaiting();

  const std::string cluster_;
  DdsEntity domain_;
  DdsEntity participant_;
  DdsEntity publisher_;
  DdsEntity subscriber_;
  DdsTopic<procgen_topics_NodeStatus> nodes_;
  DdsEntity wake_;
  DdsEntity unread_nodes_;
  DdsEntity waiting_;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_PARTICIPANT_H_
