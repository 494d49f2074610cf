#include "server/cluster/cluster_options.h"

#include <algorithm>
#include <fstream>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace procgen {
namespace {

constexpr size_t kHostLengthMax = 253;

bool HasNameLettersOnly(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char letter) {
    return absl::ascii_isalnum(letter) || letter == '.' || letter == '_' || letter == '-';
  });
}

absl::Status CheckName(absl::string_view flag, const std::string& text) {
  if (text.empty() || text.size() > kClusterNameLengthMax || !HasNameLettersOnly(text)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--", flag, " is '", text.substr(0, kClusterNameLengthMax), "', allowed: 1 to ",
        kClusterNameLengthMax, " letters, digits, '.', '_' and '-' of ASCII"));
  }
  return absl::OkStatus();
}

absl::Status CheckSecurity(const ClusterSecurity& security) {
  struct File {
    absl::string_view name;
    const std::string& path;
  };
  const File files[] = {{"identity_ca", security.identity_ca},
                        {"identity_certificate", security.identity_certificate},
                        {"identity_key", security.identity_key},
                        {"permissions_ca", security.permissions_ca},
                        {"governance", security.governance},
                        {"permissions", security.permissions}};
  if (security.IsOff()) {
    return absl::OkStatus();
  }
  for (const File& file : files) {
    if (file.path.empty()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--cluster_", file.name, " is missing, allowed: all six files of security, or none"));
    }
    if (!std::ifstream(file.path).is_open()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--cluster_", file.name, ": cannot read ", file.path));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckNodeId(const std::string& node_id) { return CheckName("node_id", node_id); }

absl::Status CheckClusterOptions(const ClusterOptions& options) {
  if (absl::Status status = CheckName("cluster", options.name); !status.ok()) {
    return status;
  }
  if (absl::Status status = CheckNodeId(options.node_id); !status.ok()) {
    return status;
  }
  if (options.domain_id < 0 || options.domain_id > kClusterDomainMax) {
    return absl::InvalidArgumentError(absl::StrCat("--cluster_domain is ", options.domain_id,
                                                   ", allowed: 0 to ", kClusterDomainMax));
  }
  for (const std::string& peer : options.peers) {
    if (peer.empty() || peer.size() > kHostLengthMax || !HasNameLettersOnly(peer)) {
      return absl::InvalidArgumentError(
          absl::StrCat("--cluster_peers has '", peer.substr(0, kHostLengthMax),
                       "', allowed: names and IPv4 addresses of hosts, without a port"));
    }
  }
  return CheckSecurity(options.security);
}

}  // namespace procgen
