#include "procgen_client/client.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "procgen_client/internal/address.h"
#include "procgen_client/internal/connect_error.h"
#include "procgen_client/internal/method_call.h"
#include "procgen_client/run/grpc_run_stream.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

// HTTP/2 stream window for servers on this machine. Small, so that bytes in flight stay in the CPU
// caches: a step of 64 environments takes 0.6 of the time with gRPC's bandwidth probing.
constexpr int kLoopbackWindowBytes = 128 << 10;
// A call within the machine takes a tenth of this; a call over a network rarely takes less.
constexpr absl::Duration kNearRoundTrip = absl::Milliseconds(3);
constexpr int kNearAttempts = 5;
constexpr absl::Duration kNearTimeout = absl::Milliseconds(200);

// Largest response that can be received, in bytes; pools need it.
constexpr int kResponseBytesMax = 256 << 20;
// Backoff between gRPC's attempts to connect.
constexpr absl::Duration kReconnectBackoffMin = absl::Milliseconds(100);
constexpr absl::Duration kReconnectBackoffMax = absl::Seconds(1);

// Default of ConnectOptions::timeout, and its part while connections are refused.
constexpr absl::Duration kConnectTimeout = absl::Seconds(10);
constexpr absl::Duration kRefusedTimeout = absl::Milliseconds(1500);
// How often a failed attempt is looked at.
constexpr absl::Duration kConnectPoll = absl::Milliseconds(50);
// How long it may take to find out why there is no connection.
constexpr absl::Duration kFailureTimeout = absl::Milliseconds(500);

// How often gRPC's timer thread does the work of connections while no thread waits in a call: it
// reads replies to keepalive pings. gRPC's default of 5 s is longer than a keepalive timeout of 1
// s, so a learner that computed for some seconds lost its connections. Not changed if the variable
// is set, or gRPC is in use already.
constexpr char kPollIntervalVariable[] = "GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS";
constexpr char kPollIntervalMs[] = "250";

constexpr char kGetLoad[] = "/procgen.v1.CatalogService/GetLoad";

int Milliseconds(absl::Duration duration) {
  return static_cast<int>(absl::ToInt64Milliseconds(duration));
}

// Whether the round trip shows that the server is on this machine, and not at the far end of a
// tunnel.
bool AnswersAtOnce(const std::shared_ptr<grpc::Channel>& channel, CallOptions options) {
  // Far above a round trip, because cancelled calls would show up as errors in the server's
  // metrics.
  options.timeout = kNearTimeout;
  for (int attempt = 0; attempt < kNearAttempts; ++attempt) {
    const auto begin = std::chrono::steady_clock::now();
    CallMethod(channel, options, kGetLoad, "").IgnoreError();  // any response counts
    const absl::Duration round_trip = absl::FromChrono(std::chrono::steady_clock::now() - begin);
    if (round_trip < kNearRoundTrip) {
      return true;
    }
    if (round_trip >= kNearTimeout) {
      return false;
    }
  }
  return false;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Client>> Client::Connect(const std::string& address,
                                                        const ConnectOptions& options) {
  if (absl::Status status = CheckAddress(address); !status.ok()) {
    return status;
  }
  setenv(kPollIntervalVariable, kPollIntervalMs, /*overwrite=*/0);
  absl::StatusOr<Credentials> credentials =
      options.credentials.has_value() ? *options.credentials : Credentials::FromEnvironment();
  if (!credentials.ok()) {
    return credentials.status();
  }
  const auto channel_credentials = ChannelCredentialsOf(*credentials, address);
  if (!channel_credentials.ok()) {
    return channel_credentials.status();
  }
  grpc::ChannelArguments arguments = options.channel_arguments;
  arguments.SetMaxReceiveMessageSize(kResponseBytesMax);
  // Servers do not compress messages. A compressed one could expand from kilobytes to gigabytes.
  arguments.SetInt(GRPC_COMPRESSION_CHANNEL_ENABLED_ALGORITHMS_BITSET, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  // One connection per client, not shared within the process.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, Milliseconds(options.keepalive_time));
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, Milliseconds(options.keepalive_timeout));
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, Milliseconds(kReconnectBackoffMin));
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, Milliseconds(kReconnectBackoffMin));
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, Milliseconds(kReconnectBackoffMax));
  const auto connect = [&]() -> absl::StatusOr<std::unique_ptr<Client>> {
    const std::shared_ptr<grpc::Channel> channel =
        grpc::CreateCustomChannel(address, *channel_credentials, arguments);
    std::unique_ptr<Client> client(new Client(
        channel, {credentials->token, options.call_timeout,
                  options.calls != nullptr ? options.calls : std::make_shared<OpenCalls>()}));
    if (!options.waits_for_server) {
      return client;
    }
    absl::Status status =
        client->AwaitConnection(channel.get(), address, !credentials->ca.empty(), options.timeout);
    if (!status.ok()) {
      return status;
    }
    return client;
  };
  if (!IsThisMachine(address)) {
    return connect();
  }
  // This machine is never behind a proxy, whatever http_proxy says.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  grpc::ChannelArguments far_arguments = arguments;
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kLoopbackWindowBytes);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  auto near = connect();
  if (!near.ok() || !options.waits_for_server ||
      AnswersAtOnce((*near)->channel_, (*near)->call_options_)) {
    return near;
  }
  arguments.Swap(far_arguments);
  return connect();
}

absl::Status Client::AwaitConnection(grpc::Channel* channel, const std::string& address,
                                     bool uses_tls, std::optional<absl::Duration> timeout) {
  const absl::Time begin = absl::Now();
  const absl::Time deadline = begin + timeout.value_or(kConnectTimeout);
  const absl::Time refused_deadline = begin + timeout.value_or(kRefusedTimeout);
  while (!channel->WaitForConnected(
      absl::ToChronoTime(std::min(deadline, absl::Now() + kConnectPoll)))) {
    const bool is_late = absl::Now() >= deadline;
    if (!is_late && channel->GetState(false) != GRPC_CHANNEL_TRANSIENT_FAILURE) {
      continue;
    }
    const std::string refusal = WhyRefused(address);
    if (!refusal.empty()) {
      if (absl::Now() >= refused_deadline) {
        return absl::UnavailableError(
            absl::StrCat("no server listens at ", address, ": ", refusal));
      }
      continue;
    }
    const std::string reason = WhyNotConnected();
    const std::string explanation = ExplainConnectError(address, reason, uses_tls);
    if (!explanation.empty()) {
      return absl::UnavailableError(absl::StrCat("cannot connect to ", address, ": ", explanation));
    }
    if (is_late) {
      return absl::UnavailableError(absl::StrCat("no server answers at ", address, " within ",
                                                 absl::FormatDuration(deadline - begin), ": ",
                                                 reason, LikelyCause(reason, uses_tls)));
    }
  }
  return absl::OkStatus();
}

std::string Client::WhyNotConnected() const {
  // A call that does not wait for the connection fails as it did.
  const absl::Status status = Call(kGetLoad, "", kFailureTimeout).status();
  return absl::IsUnavailable(status) ? std::string(status.message())
                                     : "it has not answered in time";
}

Client::Client(std::shared_ptr<grpc::Channel> channel, CallOptions options)
    : call_options_(std::move(options)), channel_(std::move(channel)) {}

template <typename Response>
absl::StatusOr<Response> Client::CallUnary(const std::string& path,
                                           const google::protobuf::MessageLite& request) {
  const absl::StatusOr<std::string> bytes = Call(path, request.SerializeAsString());
  if (!bytes.ok()) {
    return bytes.status();
  }
  Response response;
  if (!response.ParseFromString(*bytes)) {
    return absl::InternalError("the server's answer: not a message");
  }
  return response;
}

absl::StatusOr<v1::Catalog> Client::GetCatalog() {
  return CallUnary<v1::Catalog>("/procgen.v1.CatalogService/GetCatalog", v1::GetCatalogRequest());
}

absl::StatusOr<v1::Load> Client::GetLoad() {
  return CallUnary<v1::Load>(kGetLoad, v1::GetLoadRequest());
}

absl::StatusOr<v1::ListNodesResponse> Client::ListNodes() {
  return CallUnary<v1::ListNodesResponse>("/procgen.v1.ClusterService/ListNodes",
                                          v1::ListNodesRequest());
}

absl::StatusOr<v1::Pool> Client::GetPool(const std::string& name) {
  v1::GetPoolRequest request;
  request.set_name(name);
  return CallUnary<v1::Pool>("/procgen.v1.PoolService/GetPool", request);
}

absl::StatusOr<std::vector<v1::Pool>> Client::ListPools() {
  std::vector<v1::Pool> pools;
  v1::ListPoolsRequest request;
  do {
    absl::StatusOr<v1::ListPoolsResponse> page =
        CallUnary<v1::ListPoolsResponse>("/procgen.v1.PoolService/ListPools", request);
    if (!page.ok()) {
      return page.status();
    }
    pools.insert(pools.end(), page->pools().begin(), page->pools().end());
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return pools;
}

absl::StatusOr<v1::Episode> Client::GetEpisode(const std::string& pool, int32_t environment,
                                               v1::EpisodeSelector selector) {
  v1::GetEpisodeRequest request;
  request.set_pool(pool);
  request.set_environment(environment);
  request.set_selector(selector);
  return EpisodeOf(request);
}

absl::StatusOr<v1::Episode> Client::FindEpisode(const std::string& pool, int32_t environment,
                                                int64_t fingerprint) {
  v1::GetEpisodeRequest request;
  request.set_pool(pool);
  request.set_environment(environment);
  request.set_fingerprint(fingerprint);
  return EpisodeOf(request);
}

absl::StatusOr<v1::Episode> Client::EpisodeOf(const v1::GetEpisodeRequest& request) {
  return CallUnary<v1::Episode>("/procgen.v1.PoolService/GetEpisode", request);
}

std::unique_ptr<PoolWatch> Client::Watch(const v1::WatchPoolRequest& request) {
  return std::make_unique<PoolWatch>(channel_, call_options_.token, request);
}

absl::StatusOr<std::string> Client::Call(const std::string& path, absl::string_view request,
                                         std::optional<absl::Duration> timeout) const {
  CallOptions options = call_options_;
  options.timeout = timeout.value_or(options.timeout);
  return CallMethod(channel_, options, path, request);
}

std::unique_ptr<RunStream> Client::OpenRunPool(const std::shared_ptr<EventQueue>& events) {
  return std::make_unique<GrpcRunStream>(channel_, call_options_.token, events);
}

std::unique_ptr<MessageWatch> Client::WatchMessages(const std::string& path,
                                                    absl::string_view request) {
  return std::make_unique<MessageWatch>(channel_, call_options_, path, request);
}

}  // namespace procgen_client
