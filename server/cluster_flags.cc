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
          "name of this server, unique in its cluster. Empty: a random name, which persists only "
          "with --state_dir");
ABSL_FLAG(std::string, advertised_address, "",
          "address where clients and nodes reach this server: HOST:PORT (port 0: the listening "
          "port) or unix:PATH. Empty: --address");
ABSL_FLAG(std::string, cluster_identity_ca, "",
          "PEM file of the authority that signs the nodes' certificates; enables DDS Security "
          "together with the five other --cluster_ files. Empty: off");
ABSL_FLAG(std::string, cluster_identity_certificate, "",
          "PEM file of the certificate that this node presents to the others");
ABSL_FLAG(std::string, cluster_identity_key, "",
          "PEM file of the key of --cluster_identity_certificate");
ABSL_FLAG(std::string, cluster_permissions_ca, "",
          "PEM file of the authority that signs --cluster_governance and --cluster_permissions");
ABSL_FLAG(std::string, cluster_governance, "",
          "S/MIME file of the domain's governance: what DDS encrypts and signs");
ABSL_FLAG(std::string, cluster_permissions, "",
          "S/MIME file of this node's permissions: the clusters that it may join");

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
  config->draws_node_id = cluster.node_id.empty();
  if (config->draws_node_id) {
    cluster.node_id = RandomNodeId();
  }
  config->server.advertised_address = absl::GetFlag(FLAGS_advertised_address);
  cluster.address = config->server.advertised_address.empty() ? config->server.address
                                                              : config->server.advertised_address;
  cluster.security = {.identity_ca = absl::GetFlag(FLAGS_cluster_identity_ca),
                      .identity_certificate = absl::GetFlag(FLAGS_cluster_identity_certificate),
                      .identity_key = absl::GetFlag(FLAGS_cluster_identity_key),
                      .permissions_ca = absl::GetFlag(FLAGS_cluster_permissions_ca),
                      .governance = absl::GetFlag(FLAGS_cluster_governance),
                      .permissions = absl::GetFlag(FLAGS_cluster_permissions)};
}

}  // namespace procgen
