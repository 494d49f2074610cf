#ifndef SERVER_CLUSTER_DOMAIN_CONFIG_H_
#define SERVER_CLUSTER_DOMAIN_CONFIG_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/cluster/cluster_options.h"

namespace procgen {

// Returns the interface address for a node with gRPC at `address`: loopback for nodes that only
// this machine can reach; a specific address itself; else empty, so that Cyclone DDS chooses.
std::string InterfaceOf(const std::string& address);

// Returns the domain's configuration of Cyclone DDS as XML. `peer_addresses`: of all peers.
std::string DomainConfig(const ClusterOptions& options,
                         const std::vector<std::string>& peer_addresses);

}  // namespace procgen

#endif  // SERVER_CLUSTER_DOMAIN_CONFIG_H_
