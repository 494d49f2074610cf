#ifndef PROCGEN_CLIENT_INTERNAL_ADDRESS_H_
#define PROCGEN_CLIENT_INTERNAL_ADDRESS_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace procgen_client {

// INVALID_ARGUMENT unless `address` is a host with a port, or has one of gRPC's other schemes.
absl::Status CheckAddress(absl::string_view address);

// Returns why nothing can be listening at `address`, "Connection refused" or "No such file or
// directory"; empty: something may be listening. Blocks for at most half a second per address of
// the host.
std::string WhyRefused(const std::string& address);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_ADDRESS_H_
