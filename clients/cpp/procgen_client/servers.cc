#include "procgen_client/servers.h"

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "procgen/v1/cluster.pb.h"
#include "procgen_client/internal/address.h"
#include "procgen_client/run/recovering_stream.h"
#include "procgen_client/sharded_pool.h"

namespace procgen_client {
namespace {

constexpr absl::string_view kClusterScheme = "cluster:";
// Of connections to several servers: idle time before a keepalive ping, time for its reply, and for
// an answer to a call; and time until one of them must answer.
constexpr absl::Duration kShardKeepalive = absl::Seconds(1);
constexpr absl::Duration kShardConnectTimeout = absl::Seconds(10);
// Time for a server to list its cluster, and between two times that it is asked.
constexpr absl::Duration kListTimeout = absl::Milliseconds(500);
constexpr absl::Duration kRefreshInterval = absl::Milliseconds(100);

}  // namespace

absl::StatusOr<std::shared_ptr<Servers>> Servers::Connect(absl::string_view addresses,
                                                          ConnectOptions options) {
  std::vector<std::string> given = absl::StrSplit(addresses, ',');
  for (const std::string& each : given) {
    if (absl::Status status = CheckAddress(absl::StripPrefix(each, kClusterScheme)); !status.ok()) {
      return status;
    }
  }
  if (options.credentials == std::nullopt) {
    absl::StatusOr<Credentials> credentials = Credentials::FromEnvironment();
    if (!credentials.ok()) {
      return credentials.status();
    }
    options.credentials = *std::move(credentials);
  }
  for (const std::string& each : given) {
    absl::Status status = CheckCredentials(*options.credentials,
                                           std::string(absl::StripPrefix(each, kClusterScheme)));
    if (!status.ok()) {
      return status;
    }
  }
  const bool is_single = given.size() == 1 && !absl::StartsWith(given.front(), kClusterScheme) &&
                         Ipv4AddressesOf(given.front()).size() < 2;
  if (options.calls == nullptr) {
    options.calls = std::make_shared<OpenCalls>();
  }
  if (!is_single) {
    options.waits_for_server = false;
    options.keepalive_time = kShardKeepalive;
    options.keepalive_timeout = kShardKeepalive;
  }
  std::shared_ptr<Servers> servers(new Servers(std::move(given), std::move(options)));
  servers->is_single_ = is_single;
  if (is_single) {
    absl::Status status = servers->Add(servers->given_.front());
    if (!status.ok()) {
      return status;
    }
    servers->first_ = servers->All().front();
    return servers;
  }
  if (absl::Status status = servers->AwaitFirst(); !status.ok()) {
    return status;
  }
  return servers;
}

absl::Status Servers::AwaitFirst() {
  const absl::Time deadline = SteadyNow() + options_.timeout.value_or(kShardConnectTimeout);
  absl::Status status = absl::UnavailableError("no server is known");
  do {
    Refresh(/*with_names=*/true);
    for (const std::shared_ptr<Client>& client : All()) {
      status = client->Call("/procgen.v1.CatalogService/GetLoad", "", kShardKeepalive).status();
      if (status.ok()) {
        first_ = client;
        return status;
      }
      if (absl::IsUnauthenticated(status) || absl::IsPermissionDenied(status)) {
        return status;
      }
    }
    absl::SleepFor(kRefreshInterval);
  } while (SteadyNow() < deadline);
  return status;
}

std::vector<std::shared_ptr<Client>> Servers::All() const {
  absl::MutexLock lock(&mutex_);
  return clients_;
}

void Servers::Refresh(bool with_names) {
  {
    absl::MutexLock lock(&mutex_);
    const absl::Time now = SteadyNow();
    if (now - refresh_time_ < kRefreshInterval) {
      return;
    }
    refresh_time_ = now;
  }
  for (const std::string& each : given_) {
    absl::string_view address = each;
    if (absl::ConsumePrefix(&address, kClusterScheme)) {
      RefreshCluster(std::string(address));
    } else if (with_names) {
      RefreshName(each);
    }
  }
}

void Servers::RefreshName(const std::string& given) {
  const std::vector<std::string> addresses = Ipv4AddressesOf(given);
  for (const std::string& each : addresses) {
    if (addresses.size() > 1) {
      Add(each, given.substr(0, given.rfind(':'))).IgnoreError();
    }
  }
  if (addresses.size() < 2) {
    Add(given).IgnoreError();
  }
}

void Servers::RefreshCluster(const std::string& address) {
  Add(address).IgnoreError();
  for (const std::shared_ptr<Client>& client : All()) {
    const auto listed = client->Call("/procgen.v1.ClusterService/ListNodes", "", kListTimeout);
    procgen::v1::ListNodesResponse nodes;
    if (!listed.ok() || !nodes.ParseFromString(*listed)) {
      continue;
    }
    for (const procgen::v1::Node& node : nodes.nodes()) {
      if (!node.draining() && CheckAddress(node.address()).ok()) {
        Add(node.address()).IgnoreError();
      }
    }
    return;
  }
}

absl::Status Servers::Add(const std::string& address, const std::string& tls_name) {
  {
    absl::MutexLock lock(&mutex_);
    if (by_address_.contains(address)) {
      return absl::OkStatus();
    }
  }
  ConnectOptions options = options_;
  if (!tls_name.empty()) {
    options.channel_arguments.SetSslTargetNameOverride(tls_name);
  }
  absl::StatusOr<std::unique_ptr<Client>> client = Client::Connect(address, options);
  if (!client.ok()) {
    return client.status();
  }
  absl::MutexLock lock(&mutex_);
  if (const auto [place, is_new] = by_address_.try_emplace(address, *std::move(client)); is_new) {
    clients_.push_back(place->second);
  }
  return absl::OkStatus();
}

Client* PoolPlace::Next(int attempt) {
  if (servers_ == nullptr || attempt == 0) {
    return current_.get();
  }
  servers_->Refresh(/*with_names=*/attempt % static_cast<int>(servers_->All().size()) == 0);
  const std::vector<std::shared_ptr<Client>> all = servers_->All();
  const auto place = std::find(all.begin(), all.end(), current_);
  current_ = all[static_cast<size_t>(place - all.begin() + 1) % all.size()];
  return current_.get();
}

bool PoolPlace::IsHomeBack() {
  if (servers_ != nullptr) {
    servers_->Refresh(/*with_names=*/false);  // while there are members to ask
  }
  if (current_ == home_ || !home_->is_connected()) {
    return false;
  }
  current_ = home_;
  return true;
}

procgen::StatusOr<std::unique_ptr<Pool>> CreatePool(const std::shared_ptr<Servers>& servers,
                                                    const procgen::PoolOptions& options,
                                                    const RemotePoolOptions& remote) {
  return servers->is_single() ? RemotePool::Create(servers->first(), options, remote)
                              : ShardedPool::Create(servers, options, remote);
}

}  // namespace procgen_client
