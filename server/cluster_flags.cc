#include "server/cluster_flags.h"

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

ABSL_FLAG(std::string, cluster, "",
          "name of the cluster that this server is a node of: servers of one name and domain find "
          "each other. Empty: none");
ABSL_FLAG(int32_t, cluster_domain, 0, "number of the DDS domain, which tells the ports: 0 to 230");
ABSL_FLAG(std::vector<std::string>, cluster_peers, {},
          "hosts of the other nodes, with commas, for networks without multicast: names or IPv4 "
          "addresses; a name may have several. Empty: whoever hears a multicast");
ABSL_FLAG(std::string, node_id, "",
          "what this server is called in its cluster, where no other may be called so; empty: a "
          "random name, for as long as it runs, or as long as it has the same --state_dir");
ABSL_FLAG(std::string, advertised_address, "",
          "where clients and nodes reach this server, as its cluster tells them: HOST:PORT (port "
          "0: the one that it listens on) or unix:PATH. Empty: as --address");
ABSL_FLAG(std::string, cluster_identity_ca, "",
          "PEM file of the certificate that vouches for nodes of the cluster; with the five flags "
          "below DDS Security is on. Empty: off");
ABSL_FLAG(std::string, cluster_identity_certificate, "",
          "PEM file of the certificate that this node shows to the others");
ABSL_FLAG(std::string, cluster_identity_key, "",
          "PEM file of the key of --cluster_identity_certificate");
ABSL_FLAG(std::string, cluster_permissions_ca, "",
          "PEM file of the certificate that vouches for the two files below");
ABSL_FLAG(std::string, cluster_governance, "",
          "S/MIME file of the domain's governance: what is encrypted and signed");
ABSL_FLAG(std::string, cluster_permissions, "",
          "S/MIME file of this node's permissions: in which clusters it may be");

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
