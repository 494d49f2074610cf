#include "procgen_client/internal/address.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace procgen_client {
namespace {

constexpr int kProbeTimeoutMs = 500;
constexpr int32_t kPortMax = 65535;
// gRPC's schemes other than dns, whose targets gRPC checks.
constexpr absl::string_view kOtherSchemes[] = {
    "unix:", "unix-abstract:", "vsock:", "ipv4:", "ipv6:", "xds:"};

struct HostPort {
  std::string host;  // without brackets
  std::string port;
};

HostPort Split(absl::string_view address) {
  absl::ConsumePrefix(&address, "dns:///");
  const size_t colon = address.rfind(':');
  if (colon == absl::string_view::npos) {
    return {std::string(address), ""};
  }
  absl::string_view host = address.substr(0, colon);
  if (absl::ConsumePrefix(&host, "[") && !absl::ConsumeSuffix(&host, "]")) {
    return {};
  }
  return {std::string(host), std::string(address.substr(colon + 1))};
}

// Returns the error of connecting a plain socket; 0: it connected, or it is not known in time.
int ConnectError(int family, const sockaddr* address, socklen_t size) {
  const int line = socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (line < 0) {
    return errno;
  }
  const absl::Cleanup close_line = [line] { close(line); };
  if (connect(line, address, size) == 0) {
    return 0;
  }
  if (errno != EINPROGRESS) {
    return errno;
  }
  pollfd event = {.fd = line, .events = POLLOUT, .revents = 0};
  if (poll(&event, 1, kProbeTimeoutMs) != 1) {
    return 0;
  }
  int error = 0;
  socklen_t error_size = sizeof(error);
  getsockopt(line, SOL_SOCKET, SO_ERROR, &error, &error_size);
  return error;
}

int UnixConnectError(absl::string_view path) {
  sockaddr_un address = {};
  if (path.size() >= sizeof(address.sun_path)) {
    return 0;
  }
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, path.size());
  return ConnectError(AF_UNIX, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
}

// Returns ECONNREFUSED if an address of the host refuses the connection and none accepts it;
// else 0.
int TcpConnectError(const HostPort& target) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(target.host.c_str(), target.port.c_str(), &hints, &found) != 0) {
    return 0;
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
  int refusal = 0;
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    const int error = ConnectError(each->ai_family, each->ai_addr, each->ai_addrlen);
    if (error == 0) {
      return 0;
    }
    if (error == ECONNREFUSED) {
      refusal = error;
    }
  }
  return refusal;
}

}  // namespace

absl::Status CheckAddress(absl::string_view address) {
  for (const absl::string_view scheme : kOtherSchemes) {
    if (absl::StartsWith(address, scheme)) {
      return absl::OkStatus();
    }
  }
  const HostPort target = Split(address);
  const bool is_ipv6 = absl::StartsWith(absl::StripPrefix(address, "dns:///"), "[");
  int32_t port = 0;
  if (target.host.empty() || absl::StrContains(target.host, '/') ||
      (!is_ipv6 && absl::StrContains(target.host, ':')) || !absl::SimpleAtoi(target.port, &port) ||
      port < 1 || port > kPortMax) {
    return absl::InvalidArgumentError(absl::StrCat("the address is '", address,
                                                   "'; it is host:port (localhost:50051, "
                                                   "[::1]:50051) or unix:PATH"));
  }
  return absl::OkStatus();
}

std::vector<std::string> Ipv4AddressesOf(const std::string& address) {
  const HostPort target = Split(address);
  if (target.host.empty() || absl::StrContains(target.host, ':')) {
    return {};
  }
  addrinfo hints = {};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(target.host.c_str(), nullptr, &hints, &found) != 0) {
    return {};
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
  std::vector<std::string> addresses;
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    char text[INET_ADDRSTRLEN];
    const auto* ipv4 = reinterpret_cast<const sockaddr_in*>(each->ai_addr);
    inet_ntop(AF_INET, &ipv4->sin_addr, text, sizeof(text));
    addresses.push_back(absl::StrCat(text, ":", target.port));
  }
  std::sort(addresses.begin(), addresses.end());
  addresses.erase(std::unique(addresses.begin(), addresses.end()), addresses.end());
  return addresses;
}

std::string WhyRefused(const std::string& address) {
  absl::string_view path = address;
  const bool is_unix = absl::ConsumePrefix(&path, "unix:");
  const int error = is_unix ? UnixConnectError(path) : TcpConnectError(Split(address));
  if (error == ECONNREFUSED) {
    return "Connection refused";
  }
  return error == ENOENT ? "No such file or directory" : "";
}

}  // namespace procgen_client
