#ifndef SERVER_CLUSTER_CLUSTER_H_
#define SERVER_CLUSTER_CLUSTER_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/cluster/cluster_options.h"
#include "server/cluster/node_status.h"
#include "server/cluster/subscription.h"
#include "server/cluster/timing.h"

namespace procgen {

// The addresses (IPv4) of a host, in any order; none if it has none, now. May block.
using HostResolver = std::function<std::vector<std::string>(const std::string& host)>;
// Asks the system's resolver.
std::vector<std::string> ResolveHost(const std::string& host);

// This process as a node of a cluster: tells the others how it is, and knows how they are. Nodes
// find each other by themselves, and what one says reaches those that come later, too.
// Threads: any method from any thread.
class Cluster {
 public:
  // Joins; nobody sees this node before it publishes its status. Blocks for some 10 ms, and longer
  // if names of peers are resolved slowly.
  // Errors: INVALID_ARGUMENT as CheckClusterOptions; FAILED_PRECONDITION files of security that
  // cannot be used, no network, or more nodes of the domain on this machine than
  // kNodesOfMachineMax; the message says what Cyclone DDS said.
  // `resolve`, asked for the peers at first and from time to time, must be callable while there is
  // a cluster.
  static absl::StatusOr<std::unique_ptr<Cluster>> Join(const ClusterOptions& options,
                                                       HostResolver resolve = ResolveHost);
  // Joins nothing: the node is all there is, and what is told reaches nobody but those of this
  // process who ask. For a server without a cluster.
  static std::unique_ptr<Cluster> Alone(const std::string& node_id);
  // Leaves: the others see this node go at once.
  virtual ~Cluster() = default;

  // Which cluster; empty: none.
  virtual const std::string& name() const = 0;
  // Who this is.
  virtual const std::string& node_id() const = 0;

  // Tells the others how this node is; to be called when that changes, and about once a second.
  // `status` bears the node's id whether the caller put it in or not.
  virtual void Publish(NodeStatus status) = 0;
  // The nodes that are alive, by node_id; this one, too, once it has published.
  virtual std::vector<NodeStatus> Nodes() const = 0;

  // `changed` is called after a node came, went or changed, on a thread of the
  // cluster's or of who publishes; it must not block. It is called kTellIntervalMin apart at least,
  // so not for each change where they come in quick succession, but always after the last.
  virtual Subscription Subscribe(absl::AnyInvocable<void()> changed) = 0;
};

// Where all clusters of this process report what concerns an operator, from any thread; by default
// on standard error. To be called before any is joined.
using ClusterLog = std::function<void(bool is_error, absl::string_view message)>;
void LogClusterTo(ClusterLog log);

}  // namespace procgen

#endif  // SERVER_CLUSTER_CLUSTER_H_
