#include "tests/service/fleet/cluster_credentials.h"

#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace procgen {
namespace {

std::string Template(const std::string& name) {
  std::ifstream file(absl::StrCat(PROCGEN_SOURCE_DIR, "/server/cluster/security/", name));
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

ClusterCredentials::ClusterCredentials(const std::string& cluster) {
  files_.MakeAuthority("ca");
  files_.Make("ca", "node", "/CN=node", "DNS:node");
  files_.Write("governance.xml", Template("governance.xml"));
  files_.Write("permissions.xml",
               absl::StrReplaceAll(Template("permissions.xml"),
                                   {{"SUBJECT", "CN=node"}, {"CLUSTER", cluster}}));
  files_.Sign("ca", "governance.xml", "governance.p7s");
  files_.Sign("ca", "permissions.xml", "permissions.p7s");
}

ClusterSecurity ClusterCredentials::security() const {
  return {.identity_ca = files_.Path("ca.pem"),
          .identity_certificate = files_.Path("node.pem"),
          .identity_key = files_.Path("node.key"),
          .permissions_ca = files_.Path("ca.pem"),
          .governance = files_.Path("governance.p7s"),
          .permissions = files_.Path("permissions.p7s")};
}

}  // namespace procgen
