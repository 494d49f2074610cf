#ifndef SERVER_CLUSTER_CLUSTER_OPTIONS_H_
#define SERVER_CLUSTER_CLUSTER_OPTIONS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace procgen {

inline constexpr int32_t kClusterDomainMax = 230;  // its ports are the last below 65536
inline constexpr int kClusterNameLengthMax = 64;
// Maximum nodes of a domain on one machine.
inline constexpr int kNodesOfMachineMax = 32;
// The same with peers, each of which is probed at as many ports.
inline constexpr int kNodesOfPeerMax = 8;

// The cluster to join, and the identity of this node.
struct ClusterOptions {
  std::string name;       // nodes with the same name form a cluster; letters, digits, '.', '_', '-'
  int32_t domain_id = 0;  // nodes must be in the same domain; [0, kClusterDomainMax]
  // Hosts to probe for nodes, by name or IPv4 address; for networks without multicast. Empty:
  // discovery by multicast.
  std::vector<std::string> peers;
  std::string node_id = "node";  // unique in the cluster; same characters as `name`
  // The gRPC address of this node, "HOST:PORT" or "unix:PATH". It selects the network interface of
  // the cluster's traffic: loopback for a loopback host; the interface with exactly this address;
  // else the system's default. The port is not used here.
  std::string address;
};

// Errors: INVALID_ARGUMENT not a valid node id; the message contains the allowed values.
absl::Status CheckNodeId(const std::string& node_id);

// Errors: INVALID_ARGUMENT an invalid value; the message contains the server's flag, the value and
// the allowed values.
absl::Status CheckClusterOptions(const ClusterOptions& options);

}  // namespace procgen

#endif  // SERVER_CLUSTER_CLUSTER_OPTIONS_H_
