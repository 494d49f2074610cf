#ifndef SERVER_RPC_SERVICES_CLONE_SOURCE_ALLOWLIST_H_
#define SERVER_RPC_SERVICES_CLONE_SOURCE_ALLOWLIST_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/net/address.h"

namespace procgen {

// The servers that CloneStates may connect to. Threads: immutable.
class CloneSourceAllowlist {
 public:
  // Allows no server.
  CloneSourceAllowlist() = default;

  // Parses "none" or a comma-separated list of HOST (any port), HOST:PORT, unix:PATH and "local"
  // (loopback and all unix sockets of this machine). Errors: INVALID_ARGUMENT any other text.
  static absl::StatusOr<CloneSourceAllowlist> Parse(absl::string_view list);

  bool Allows(const Address& address) const;

 private:
  bool allows_local_ = false;
  std::vector<std::string> hosts_;  // with any port; lower case
  std::vector<Address> addresses_;  // lower case
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_CLONE_SOURCE_ALLOWLIST_H_
