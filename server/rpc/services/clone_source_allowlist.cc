#include "server/rpc/services/clone_source_allowlist.h"

#include <algorithm>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace procgen {

absl::StatusOr<CloneSourceAllowlist> CloneSourceAllowlist::Parse(absl::string_view list) {
  CloneSourceAllowlist allowlist;
  if (list == "none") {
    return allowlist;
  }
  for (const absl::string_view entry : absl::StrSplit(list, ',')) {
    if (entry == "local") {
      allowlist.allows_local_ = true;
      continue;
    }
    absl::StatusOr<Address> address = ParseAddress(entry);
    if (address.ok()) {
      absl::AsciiStrToLower(&address->host);
      allowlist.addresses_.push_back(*std::move(address));
      continue;
    }
    const absl::StatusOr<Address> with_port = ParseAddress(absl::StrCat(entry, ":0"));
    if (!with_port.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("has '", entry,
                       "', allowed: 'none', or a comma-separated list of HOST, HOST:PORT, "
                       "unix:PATH and 'local'"));
    }
    allowlist.hosts_.push_back(absl::AsciiStrToLower(with_port->host));
  }
  return allowlist;
}

bool CloneSourceAllowlist::Allows(const Address& address) const {
  if (allows_local_ && IsLocal(address)) {
    return true;
  }
  const std::string host = absl::AsciiStrToLower(address.host);
  if (address.unix_path.empty() && std::find(hosts_.begin(), hosts_.end(), host) != hosts_.end()) {
    return true;
  }
  return std::any_of(addresses_.begin(), addresses_.end(), [&](const Address& allowed) {
    return allowed.unix_path == address.unix_path && allowed.host == host &&
           allowed.port == address.port;
  });
}

}  // namespace procgen
