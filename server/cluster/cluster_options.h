#ifndef SERVER_CLUSTER_CLUSTER_OPTIONS_H_
#define SERVER_CLUSTER_CLUSTER_OPTIONS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace procgen {

inline constexpr int32_t kClusterDomainMax = 230;  // whose ports are the last below 65536
inline constexpr int kClusterNameLengthMax = 64;
// Nodes of one cluster on one machine: peers without multicast are looked for at as many ports.
inline constexpr int kNodesOfMachineMax = 32;

// How a node proves who it is, and who else it believes: paths of the files of DDS Security. All of
// them, or none.
struct ClusterSecurity {
  std::string identity_ca;           // PEM: vouches for the nodes
  std::string identity_certificate;  // PEM: this node's
  std::string identity_key;          // PEM: the key of it
  std::string permissions_ca;        // PEM: vouches for the two below
  std::string governance;            // S/MIME: what is protected, and how
  std::string permissions;           // S/MIME: which node may say what

  bool IsOff() const { return *this == ClusterSecurity(); }

  friend bool operator==(const ClusterSecurity&, const ClusterSecurity&) = default;
};

// Which cluster to join, and as whom.
struct ClusterOptions {
  std::string name;       // nodes of one name meet; letters, digits, '.', '_', '-'
  int32_t domain_id = 0;  // nodes of one domain meet; [0, kClusterDomainMax]
  // Hosts, by name or address of IPv4, that are asked who is there; for networks without multicast.
  // Empty: whoever hears a multicast.
  std::vector<std::string> peers;
  std::string node_id = "node";  // of this node; no other may have it; as a name
  // Where this node answers gRPC, "HOST:PORT" or "unix:PATH". The cluster speaks where that host
  // is: on loopback only, for one; on an interface that has just this address; or where the
  // system sends what goes elsewhere. The port is of no interest here.
  std::string address;
  ClusterSecurity security;
};

// Errors: INVALID_ARGUMENT what cannot be the id of a node; the message says what is allowed.
absl::Status CheckNodeId(const std::string& node_id);

// Errors: INVALID_ARGUMENT a value that cannot be; the message names the server's flag, what was
// given and what is allowed; or a file that cannot be read.
absl::Status CheckClusterOptions(const ClusterOptions& options);

}  // namespace procgen

#endif  // SERVER_CLUSTER_CLUSTER_OPTIONS_H_
