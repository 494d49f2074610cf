#include "server/cluster_flags.h"

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

ABSL_FLAG(std::string, cluster, "",
          "name of this server's cluster: servers with the same name and domain find each other. "
          "Empty: none");
ABSL_FLAG(int32_t, cluster_domain, 0, "DDS domain number, which determines the ports: 0 to 230");
ABSL_FLAG(std::vector<std::string>, cluster_peers, {},
          "hosts of the other nodes, comma-separated, for networks without multicast: names or "
          "IPv4 addresses; a name may have several addresses. Empty: multicast");
ABSL_FLAG(std::string, node_id, "",
          "name of this server, unique in its cluster. Empty: a random name");
ABSL_FLAG(std::string, advertised_address, "",
          "address where clients and nodes reach this server: HOST:PORT (port 0: the listening "
          "port) or unix:PATH. Empty: --address");

namespace procgen {
namespace {

std::string RandomNodeId() {
  std::random_device random;
  return absl::StrCat("node-", absl::Hex(random(), absl::kZeroPad8));
}

}  // namespace

void ReadClusterFlags(Config* config) {
  ClusterOptions& cluster = config->cluster;
  cluster.name = absl::GetFlag(FLAGS_cluster);
  cluster.domain_id = absl::GetFlag(FLAGS_cluster_domain);
  cluster.peers = absl::GetFlag(FLAGS_cluster_peers);
  cluster.node_id = absl::GetFlag(FLAGS_node_id);
  if (cluster.node_id.empty()) {
    cluster.node_id = RandomNodeId();
  }
  config->server.advertised_address = absl::GetFlag(FLAGS_advertised_address);
  cluster.address = config->server.advertised_address.empty() ? config->server.address
                                                              : config->server.advertised_address;
}

}  // namespace procgen
