#ifndef SERVER_CLUSTER_CLUSTER_H_
#define SERVER_CLUSTER_CLUSTER_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/cluster/cluster_options.h"
#include "server/cluster/node_status.h"
#include "server/cluster/timing.h"

namespace procgen {

// Returns the IPv4 addresses of a host, in any order; empty if there are none now. May block.
using HostResolver = std::function<std::vector<std::string>(const std::string& host)>;
// Uses the system's resolver.
std::vector<std::string> ResolveHost(const std::string& host);

// This process as a node of a cluster. It publishes its status and receives those of the others.
// Nodes discover each other, and the last status of a node also reaches nodes that join later.
// Threads: any method from any thread.
class Cluster {
 public:
  // Joins a cluster. Other nodes see this one after its first Publish. Blocks for about 10 ms,
  // longer if resolving names of peers is slow.
  // Errors: INVALID_ARGUMENT as CheckClusterOptions; FAILED_PRECONDITION no network, or more nodes
  // of the domain on this machine than allowed; Cyclone DDS logs the reason. `resolve`: called for
  // the peers at startup and periodically; must be callable while this exists.
  static absl::StatusOr<std::unique_ptr<Cluster>> Join(const ClusterOptions& options,
                                                       HostResolver resolve = ResolveHost);
  // For a server without a cluster: the only node is this one, visible only in this process.
  static std::unique_ptr<Cluster> Alone(const std::string& node_id);
  // Leaves: the other nodes see this immediately.
  virtual ~Cluster() = default;

  // The cluster's name; empty: none.
  virtual const std::string& name() const = 0;
  // The id of this node.
  virtual const std::string& node_id() const = 0;

  // Publishes the status of this node. Call on changes, and about once a second. The node id in
  // `status` is ignored.
  virtual void Publish(NodeStatus status) = 0;
  // The live nodes, by node_id; including this one once it has published.
  virtual std::vector<NodeStatus> Nodes() const = 0;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_CLUSTER_H_
