#ifndef SERVER_CLUSTER_DOMAIN_CONFIG_H_
#define SERVER_CLUSTER_DOMAIN_CONFIG_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/cluster/cluster_options.h"

namespace procgen {

// The address of the interface on which a node speaks that answers gRPC at `address`: the loopback
// one for nodes that only this machine can reach; one that is just this address; else empty, which
// leaves it to Cyclone DDS.
std::string InterfaceOf(const std::string& address);

// How Cyclone DDS is to run the domain, as XML. `peer_addresses`: of all peers.
std::string DomainConfig(const ClusterOptions& options,
                         const std::vector<std::string>& peer_addresses);

}  // namespace procgen

#endif  // SERVER_CLUSTER_DOMAIN_CONFIG_H_
