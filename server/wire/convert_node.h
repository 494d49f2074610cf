#ifndef SERVER_WIRE_CONVERT_NODE_H_
#define SERVER_WIRE_CONVERT_NODE_H_

#include "procgen/v1/cluster.pb.h"
#include "server/cluster/cluster.h"
#include "server/cluster/node_status.h"

namespace procgen {

v1::Node NodeMessageOf(const NodeStatus& status);

// Returns the current nodes of a cluster. Response: v1::ListNodesResponse or
// v1::WatchNodesResponse.
template <typename Response>
Response NodesMessageOf(const Cluster& cluster) {
  Response response;
  for (const NodeStatus& node : cluster.Nodes()) {
    *response.add_nodes() = NodeMessageOf(node);
    if (node.node_id == cluster.node_id()) {
      response.set_local_node(response.nodes().rbegin()->name());
    }
  }
  response.set_cluster(cluster.name());
  return response;
}

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_NODE_H_
