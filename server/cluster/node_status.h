#ifndef SERVER_CLUSTER_NODE_STATUS_H_
#define SERVER_CLUSTER_NODE_STATUS_H_

#include <cstdint>
#include <string>

namespace procgen {

// The published status of a server.
struct NodeStatus {
  std::string node_id;
  std::string address;  // its gRPC address: "HOST:PORT" or "unix:PATH"
  std::string server_version;
  int32_t environment_capacity = 0;  // maximum number of environments; 0: it takes none
  int32_t env_count = 0;             // environments of all its pools
  int32_t pool_count = 0;
  int32_t worker_count = 0;
  double steps_per_second = 0;  // environment steps, over about the last second
  bool healthy = false;         // its health service reports SERVING
  bool draining = false;        // it is about to stop and takes no new pools

  friend bool operator==(const NodeStatus&, const NodeStatus&) = default;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_NODE_STATUS_H_
