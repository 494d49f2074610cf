#ifndef SERVER_NET_ADDRESS_H_
#define SERVER_NET_ADDRESS_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen {

// Address of a server: a host and a port, or a unix socket. Other gRPC targets (resolver names,
// lists) are not supported.
struct Address {
  std::string host;       // a name, or an IPv4 or IPv6 address without brackets
  uint16_t port = 0;      // with a host
  std::string unix_path;  // not empty: a unix socket; host is empty
};

// Reads "HOST:PORT", "[IPV6]:PORT" or "unix:PATH". Errors: INVALID_ARGUMENT; the message does not
// name the flag or field.
absl::StatusOr<Address> ParseAddress(absl::string_view text);

// Whether only this machine can reach the address.
bool IsLocal(const Address& address);

// Whether the address is a wildcard, which listens on all interfaces and cannot be connected to.
bool IsWildcard(const Address& address);

// Errors: UNAVAILABLE the host cannot be resolved.
absl::Status CheckResolvable(const Address& address);

// The address as an unambiguous gRPC target.
std::string GrpcTargetOf(const Address& address);

}  // namespace procgen

#endif  // SERVER_NET_ADDRESS_H_
