#include "server/cluster/cluster_options.h"

#include <algorithm>

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
  return absl::OkStatus();
}

}  // namespace procgen
