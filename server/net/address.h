#ifndef SERVER_NET_ADDRESS_H_
#define SERVER_NET_ADDRESS_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen {

// Where a server listens: a host and a port, or a socket in the file system. gRPC takes many other
// things for an address (names of resolvers, lists); these two are what we take.
struct Address {
  std::string host;       // a name, or an address of IPv4 or IPv6, without brackets
  uint16_t port = 0;      // with a host
  std::string unix_path;  // not empty: a socket, and no host
};

// Reads "HOST:PORT", "[IPV6]:PORT" or "unix:PATH". Errors: INVALID_ARGUMENT, without a name for it.
absl::StatusOr<Address> ParseAddress(absl::string_view text);

// Nobody but this very machine can reach it.
bool IsLocal(const Address& address);

// Stands for all addresses of this machine, and is none that anybody could connect to.
bool IsWildcard(const Address& address);

// Whether a connection comes from this very machine. `peer`: as gRPC tells it, e.g.
// "ipv4:127.0.0.1:40000".
bool IsOnThisMachine(absl::string_view peer);

// As gRPC takes the address of a server to connect to, and cannot take for anything else.
std::string GrpcTargetOf(const Address& address);

}  // namespace procgen

#endif  // SERVER_NET_ADDRESS_H_
