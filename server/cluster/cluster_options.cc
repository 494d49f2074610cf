#include "server/cluster/cluster_options.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace procgen {
namespace {

constexpr absl::string_view kAllowedName = "1 to 64 letters, digits, '.', '_' and '-' of ASCII";
constexpr size_t kHostLengthMax = 253;

bool HasNameLettersOnly(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char letter) {
    return absl::ascii_isalnum(letter) || letter == '.' || letter == '_' || letter == '-';
  });
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
  const auto is_given = [](const File& file) { return !file.path.empty(); };
  if (std::none_of(std::begin(files), std::end(files), is_given)) {
    return absl::OkStatus();
  }
  for (const File& file : files) {
    if (!is_given(file)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "cluster_", file.name, " is missing, allowed: all six files of security, or none"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

bool IsClusterName(const std::string& text) {
  return !text.empty() && text.size() <= kClusterNameLengthMax && HasNameLettersOnly(text);
}

absl::Status CheckClusterOptions(const ClusterOptions& options) {
  if (!IsClusterName(options.name)) {
    return absl::InvalidArgumentError(absl::StrCat("cluster is '",
                                                   options.name.substr(0, kClusterNameLengthMax),
                                                   "', allowed: ", kAllowedName));
  }
  if (!IsClusterName(options.node_id)) {
    return absl::InvalidArgumentError(absl::StrCat("node_id is '",
                                                   options.node_id.substr(0, kClusterNameLengthMax),
                                                   "', allowed: ", kAllowedName));
  }
  if (options.domain_id < 0 || options.domain_id > kClusterDomainMax) {
    return absl::InvalidArgumentError(absl::StrCat("cluster_domain is ", options.domain_id,
                                                   ", allowed: 0 to ", kClusterDomainMax));
  }
  for (const std::string& peer : options.peers) {
    if (peer.empty() || peer.size() > kHostLengthMax || !HasNameLettersOnly(peer)) {
      return absl::InvalidArgumentError(
          absl::StrCat("cluster_peers has '", peer.substr(0, kHostLengthMax),
                       "', allowed: names and IPv4 addresses of hosts, without a port"));
    }
  }
  return CheckSecurity(options.security);
}

}  // namespace procgen
