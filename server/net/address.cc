#include "server/net/address.h"

#include <arpa/inet.h>
#include <netdb.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace procgen {
namespace {

bool IsHost(absl::string_view host) {
  return !host.empty() && std::all_of(host.begin(), host.end(), [](unsigned char letter) {
    return absl::ascii_isalnum(letter) || letter == '.' || letter == '-' || letter == '_';
  });
}

bool IsIpv6(const std::string& host) {
  in6_addr address = {};
  return inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

}  // namespace

absl::StatusOr<Address> ParseAddress(absl::string_view text) {
  Address address;
  if (absl::ConsumePrefix(&text, "unix:")) {
    address.unix_path = std::string(text);
    if (text.empty()) {
      return absl::InvalidArgumentError("no socket path");
    }
    return address;
  }
  const size_t colon = text.rfind(':');
  int port = -1;
  if (colon == absl::string_view::npos || !absl::SimpleAtoi(text.substr(colon + 1), &port) ||
      port < 0 || port > UINT16_MAX) {
    return absl::InvalidArgumentError("no port");
  }
  absl::string_view host = text.substr(0, colon);
  const bool has_brackets = absl::ConsumePrefix(&host, "[") && absl::ConsumeSuffix(&host, "]");
  address.host = std::string(host);
  address.port = static_cast<uint16_t>(port);
  if (has_brackets ? !IsIpv6(address.host) : !IsHost(host)) {
    return absl::InvalidArgumentError("no host");
  }
  return address;
}

bool IsLocal(const Address& address) {
  constexpr uint8_t kLoopbackNet = 127;
  if (!address.unix_path.empty() || absl::AsciiStrToLower(address.host) == "localhost") {
    return true;
  }
  uint8_t ipv4[4] = {};
  if (inet_pton(AF_INET, address.host.c_str(), ipv4) == 1) {
    return ipv4[0] == kLoopbackNet;
  }
  in6_addr ipv6 = {};
  return inet_pton(AF_INET6, address.host.c_str(), &ipv6) == 1 && IN6_IS_ADDR_LOOPBACK(&ipv6);
}

bool IsWildcard(const Address& address) {
  in_addr ipv4 = {};
  in6_addr ipv6 = {};
  return (inet_pton(AF_INET, address.host.c_str(), &ipv4) == 1 && ipv4.s_addr == INADDR_ANY) ||
         (inet_pton(AF_INET6, address.host.c_str(), &ipv6) == 1 && IN6_IS_ADDR_UNSPECIFIED(&ipv6));
}

absl::Status CheckResolvable(const Address& address) {
  addrinfo* found = nullptr;
  const int error = getaddrinfo(address.host.c_str(), nullptr, nullptr, &found);
  if (error != 0) {
    return absl::UnavailableError(
        absl::StrCat("host '", address.host, "' cannot be resolved: ", gai_strerror(error)));
  }
  freeaddrinfo(found);
  return absl::OkStatus();
}

std::string GrpcTargetOf(const Address& address) {
  if (!address.unix_path.empty()) {
    return absl::StrCat("unix:", address.unix_path);
  }
  const bool is_ipv6 = absl::StrContains(address.host, ':');
  return absl::StrCat("dns:///", is_ipv6 ? "[" : "", address.host, is_ipv6 ? "]" : "", ":",
                      address.port);
}

}  // namespace procgen
