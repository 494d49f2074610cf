#ifndef SERVER_WIRE_CONVERT_NODE_H_
#define SERVER_WIRE_CONVERT_NODE_H_

#include "procgen/v1/cluster.pb.h"
#include "server/cluster/cluster.h"
#include "server/cluster/node_status.h"

namespace procgen {

v1::Node NodeMessageOf(const NodeStatus& status);

// Returns the current nodes of a cluster.
v1::ListNodesResponse NodesMessageOf(const Cluster& cluster);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_NODE_H_
