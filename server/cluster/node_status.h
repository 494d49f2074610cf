#ifndef SERVER_CLUSTER_NODE_STATUS_H_
#define SERVER_CLUSTER_NODE_STATUS_H_

#include <cstdint>
#include <string>

namespace procgen {

// What a node does in its cluster.
enum class NodeRole : uint8_t {
  kHost,   // steps environments itself; may be given shards
  kFleet,  // spreads pools over the hosts; its capacity is 0, since it steps nothing itself
};

// A server as the others of its cluster see it.
struct NodeStatus {
  std::string node_id;
  std::string address;  // where it answers gRPC: "HOST:PORT" or "unix:PATH"
  std::string server_version;
  NodeRole role = NodeRole::kHost;
  int32_t environment_capacity = 0;  // environments that it takes at most; 0: it takes none
  int32_t env_count = 0;             // environments of all its pools
  int32_t pool_count = 0;
  int32_t stream_count = 0;
  int32_t worker_count = 0;
  double steps_per_second = 0;  // environment steps, over the last second or so
  bool healthy = false;         // its health service says SERVING
  bool draining = false;        // it is about to stop, and takes no new pools

  friend bool operator==(const NodeStatus&, const NodeStatus&) = default;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_NODE_STATUS_H_
