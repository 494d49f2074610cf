#ifndef PROCGEN_CLIENT_INTERNAL_ADDRESS_H_
#define PROCGEN_CLIENT_INTERNAL_ADDRESS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace procgen_client {

// INVALID_ARGUMENT unless `address` is a host with a port, or has one of gRPC's other schemes.
absl::Status CheckAddress(absl::string_view address);

// The IPv4 addresses of the host of "host:port", each with the port, in order; empty: the name
// cannot be looked up, or the address has another form. May block for seconds.
std::vector<std::string> Ipv4AddressesOf(const std::string& address);

// Returns why nothing can be listening at `address`, "Connection refused" or "No such file or
// directory"; empty: something may be listening. Blocks for at most half a second per address of
// the host.
std::string WhyRefused(const std::string& address);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_ADDRESS_H_
