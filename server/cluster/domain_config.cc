#include "server/cluster/domain_config.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netdb.h>
#include <netinet/in.h>

#include <algorithm>
#include <memory>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/cluster/cluster.h"
#include "server/cluster/timing.h"

namespace procgen {
namespace {

constexpr absl::string_view kLoopback = "127.0.0.1";

std::string TextOf(const in_addr& address) {
  char text[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &address, text, sizeof text);
  return text;
}

const in_addr& AddressIn(const sockaddr* address) {
  return reinterpret_cast<const sockaddr_in*>(address)->sin_addr;
}

bool IsOwnAddress(const std::string& address) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) {
    return false;
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> list(first, &freeifaddrs);
  for (const ifaddrs* each = first; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET &&
        TextOf(AddressIn(each->ifa_addr)) == address) {
      return true;
    }
  }
  return false;
}

std::string Element(absl::string_view name, absl::string_view content) {
  return absl::StrCat("<", name, ">", content, "</", name, ">");
}

std::string Milliseconds(absl::Duration duration) {
  return absl::StrCat(absl::ToInt64Milliseconds(duration), "ms");
}

}  // namespace

std::vector<std::string> ResolveHost(const std::string& host) {
  addrinfo hints = {};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* first = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &first) != 0) {
    return {};
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> list(first, &freeaddrinfo);
  std::vector<std::string> addresses;
  for (const addrinfo* each = first; each != nullptr; each = each->ai_next) {
    addresses.push_back(TextOf(AddressIn(each->ai_addr)));
  }
  std::sort(addresses.begin(), addresses.end());
  addresses.erase(std::unique(addresses.begin(), addresses.end()), addresses.end());
  return addresses;
}

std::string InterfaceOf(const std::string& address) {
  if (absl::StartsWith(address, "unix:") || absl::StartsWith(address, "[::1]:")) {
    return std::string(kLoopback);
  }
  const std::string host = address.substr(0, address.rfind(':'));
  if (host == "localhost" || absl::StartsWith(host, "127.")) {
    return std::string(kLoopback);
  }
  return IsOwnAddress(host) ? host : "";
}

std::string DomainConfig(const ClusterOptions& options,
                         const std::vector<std::string>& peer_addresses) {
  const std::string interface = InterfaceOf(options.address);
  const bool asks_peers = !options.peers.empty();
  std::string interfaces;
  if (!interface.empty()) {
    // Loopback supports multicast, although its flags do not say so.
    interfaces = Element("Interfaces", absl::StrCat("<NetworkInterface address=\"", interface,
                                                    R"(" multicast="true"/>)"));
  }
  std::string peers;
  for (const std::string& peer : peer_addresses) {
    absl::StrAppend(&peers, "<Peer address=\"", peer, "\"/>");
  }
  const int nodes_max = asks_peers ? kNodesOfPeerMax : kNodesOfMachineMax;
  const absl::Duration interval =
      std::clamp(absl::Seconds(peer_addresses.size() * static_cast<size_t>(nodes_max)) /
                     kDiscoveryMessagesPerSecondMax,
                 kDiscoveryIntervalMin, kDiscoveryIntervalMax);
  return absl::StrCat(
      "<CycloneDDS><Domain>",
      Element("General", absl::StrCat(interfaces,
                                      // Discovery by multicast, data by unicast.
                                      Element("AllowMulticast", asks_peers ? "false" : "spdp"))),
      Element(
          "Discovery",
          absl::StrCat(
              Element("ExternalDomainId", absl::StrCat(options.domain_id)),
              Element("LeaseDuration", Milliseconds(std::max(3 * interval, kDiscoveryLeaseMin))),
              Element("SPDPInterval", Milliseconds(interval)),
              // Ports that peers can guess: one set per node of a machine.
              Element("ParticipantIndex", "auto"),
              Element("MaxAutoParticipantIndex", absl::StrCat(nodes_max)),  // exclusive
              Element("Peers", peers))),
      // Larger samples are dropped on receipt; those of these topics are much smaller.
      Element("Internal",
              absl::StrCat(Element("MaxSampleSize", "64KiB"),
                           // A node leaves at once, although a crashed one acknowledges nothing.
                           Element("WriterLingerDuration", "0s"))),
      "</Domain></CycloneDDS>");
}

}  // namespace procgen
