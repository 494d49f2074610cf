#include "server/wire/convert_node.h"

#include "absl/strings/str_cat.h"

namespace procgen {

v1::Node NodeMessageOf(const NodeStatus& status) {
  v1::Node node;
  node.set_name(absl::StrCat("nodes/", status.node_id));
  node.set_address(status.address);
  node.set_server_version(status.server_version);
  node.set_environment_capacity(status.environment_capacity);
  node.set_env_count(status.env_count);
  node.set_pool_count(status.pool_count);
  node.set_worker_count(status.worker_count);
  node.set_steps_per_second(status.steps_per_second);
  node.set_healthy(status.healthy);
  node.set_draining(status.draining);
  return node;
}

v1::ListNodesResponse NodesMessageOf(const Cluster& cluster) {
  v1::ListNodesResponse response;
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
