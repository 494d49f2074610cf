#include "procgen_client/client.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/async_unary_call.h"
#include "procgen_client/internal/address.h"
#include "procgen_client/internal/answer_validation.h"
#include "procgen_client/internal/call_completions.h"
#include "procgen_client/internal/connect_error.h"
#include "procgen_client/internal/grpc_error.h"
#include "procgen_client/internal/timing.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

// Smallest Limits.request_bytes_max of any server, in bytes.
constexpr int64_t kRequestBytesAlways = 65536;
// Upper bound of a state's overhead in a request: a tag and a length.
constexpr int64_t kStateOverheadBytes = 8;

// HTTP/2 stream window for servers on this machine. Small, so that bytes in flight stay in the CPU
// caches: a step of 64 environments takes 0.6 of the time with gRPC's bandwidth probing.
constexpr int kLoopbackWindowBytes = 128 << 10;
// A call within the machine takes a tenth of this; a call over a network rarely takes less.
constexpr absl::Duration kNearRoundTrip = absl::Milliseconds(3);
constexpr int kNearAttempts = 5;
constexpr absl::Duration kNearTimeout = absl::Milliseconds(200);

// Default of ConnectOptions::timeout, and its part while connections are refused.
constexpr absl::Duration kConnectTimeout = absl::Seconds(10);
constexpr absl::Duration kRefusedTimeout = absl::Milliseconds(1500);
// How long it may take to find out why there is no connection.
constexpr absl::Duration kFailureTimeout = absl::Milliseconds(500);

// A page has 1000 pools; a list with more pages is treated as endless.
constexpr int kPoolPagesMax = 1000;

// Returns `value` if `status` is OK, else `status`.
template <typename Value>
absl::StatusOr<Value> IfValid(absl::StatusOr<Value> value, absl::Status status) {
  return status.ok() ? std::move(value) : std::move(status);
}

int Milliseconds(absl::Duration duration) {
  return static_cast<int>(absl::ToInt64Milliseconds(duration));
}

// Calls a unary method and returns its response.
template <typename Stub, typename Request, typename Response>
absl::StatusOr<Response> CallUnary(const CallOptions& options, Stub* stub,
                                   std::unique_ptr<grpc::ClientAsyncResponseReader<Response>> (
                                       Stub::*method)(grpc::ClientContext*, const Request&,
                                                      grpc::CompletionQueue*),
                                   const Request& request) {
  Cancellation cancellation(options.is_cancelled);
  grpc::ClientContext context;
  ShowToken(options.token, &context);
  if (options.timeout != absl::InfiniteDuration()) {
    context.set_deadline(absl::ToChronoTime(absl::Now() + options.timeout));
  }
  Response response;
  grpc::Status status;
  CallCompletions completions(&context, &cancellation);
  const auto call = (stub->*method)(&context, request, completions.queue());
  call->Finish(&response, &status, CallCompletions::TagOf(CallOperation::kFinish));
  completions.Await(CallOperation::kFinish);
  if (!status.ok()) {
    return ToAbslStatus(status);
  }
  return response;
}

// Whether the round trip shows that the server is on this machine, and not at the far end of a
// tunnel.
bool AnswersAtOnce(v1::CatalogService::Stub* catalog, const CallOptions& options) {
  for (int attempt = 0; attempt < kNearAttempts; ++attempt) {
    const auto begin = std::chrono::steady_clock::now();
    // Any response counts. The timeout is far above a round trip, because cancelled calls would
    // show up as errors in the server's metrics.
    CallUnary(
        {.token = options.token, .timeout = kNearTimeout, .is_cancelled = options.is_cancelled},
        catalog, &v1::CatalogService::Stub::AsyncGetLoad, v1::GetLoadRequest())
        .IgnoreError();
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
  arguments.SetMaxReceiveMessageSize(options.response_bytes_max);
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
    std::unique_ptr<Client> client(
        new Client(channel, {credentials->token, options.call_timeout, options.is_cancelled}));
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
  if (!near.ok() || AnswersAtOnce((*near)->catalog_.get(), (*near)->call_options_)) {
    return near;
  }
  arguments.Swap(far_arguments);
  return connect();
}

std::unique_ptr<Client> Client::FromChannel(const std::shared_ptr<grpc::Channel>& channel,
                                            std::string token, absl::Duration call_timeout) {
  return std::unique_ptr<Client>(new Client(channel, {std::move(token), call_timeout}));
}

absl::Status Client::AwaitConnection(grpc::Channel* channel, const std::string& address,
                                     bool uses_tls, std::optional<absl::Duration> timeout) {
  Cancellation cancellation(call_options_.is_cancelled);
  const absl::Time begin = absl::Now();
  const absl::Time deadline = begin + timeout.value_or(kConnectTimeout);
  const absl::Time refused_deadline = begin + timeout.value_or(kRefusedTimeout);
  while (!channel->WaitForConnected(
      absl::ToChronoTime(std::min(deadline, absl::Now() + kCancellationInterval)))) {
    if (cancellation.Check()) {
      return absl::CancelledError("connecting was cancelled");
    }
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
    const std::string explanation = ExplainConnectError(address, reason, uses_tls, &cancellation);
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

std::string Client::WhyNotConnected() {
  // A call that does not wait for the connection fails as it did.
  const CallOptions options = {call_options_.token, kFailureTimeout, call_options_.is_cancelled};
  const absl::Status status =
      CallUnary(options, catalog_.get(), &v1::CatalogService::Stub::AsyncGetLoad,
                v1::GetLoadRequest())
          .status();
  return absl::IsUnavailable(status) ? std::string(status.message())
                                     : "it has not answered in time";
}

Client::Client(const std::shared_ptr<grpc::Channel>& channel, CallOptions options)
    : call_options_(std::move(options)),
      catalog_(v1::CatalogService::NewStub(channel)),
      cluster_(v1::ClusterService::NewStub(channel)),
      pools_(v1::PoolService::NewStub(channel)),
      step_(v1::StepService::NewStub(channel)),
      states_(v1::StateService::NewStub(channel)),
      render_(v1::RenderService::NewStub(channel)) {}

absl::StatusOr<v1::Catalog> Client::GetCatalog() {
  return CallUnary(call_options_, catalog_.get(), &v1::CatalogService::Stub::AsyncGetCatalog,
                   v1::GetCatalogRequest());
}

absl::StatusOr<v1::Load> Client::GetLoad() {
  return CallUnary(call_options_, catalog_.get(), &v1::CatalogService::Stub::AsyncGetLoad,
                   v1::GetLoadRequest());
}

absl::StatusOr<v1::ListNodesResponse> Client::ListNodes() {
  return CallUnary(call_options_, cluster_.get(), &v1::ClusterService::Stub::AsyncListNodes,
                   v1::ListNodesRequest());
}

std::unique_ptr<NodeWatch> Client::WatchNodes() {
  return std::make_unique<NodeWatch>(call_options_.token, [this](grpc::ClientContext* context) {
    return cluster_->WatchNodes(context, v1::WatchNodesRequest());
  });
}

absl::StatusOr<v1::Pool> Client::CreatePool(const v1::PoolSpec& spec, const std::string& pool_id) {
  v1::CreatePoolRequest request;
  request.set_pool_id(pool_id);
  *request.mutable_spec() = spec;
  auto pool =
      CallUnary(call_options_, pools_.get(), &v1::PoolService::Stub::AsyncCreatePool, request);
  absl::Status status = pool.ok() ? ValidateCreatedPool(*pool, request) : pool.status();
  return IfValid(std::move(pool), std::move(status));
}

absl::StatusOr<v1::Pool> Client::GetPool(const std::string& name) {
  v1::GetPoolRequest request;
  request.set_name(name);
  auto pool = CallUnary(call_options_, pools_.get(), &v1::PoolService::Stub::AsyncGetPool, request);
  absl::Status status = pool.ok() ? ValidatePool(*pool, name) : pool.status();
  return IfValid(std::move(pool), std::move(status));
}

absl::StatusOr<std::vector<v1::Pool>> Client::ListPools() {
  std::vector<v1::Pool> pools;
  v1::ListPoolsRequest request;
  for (int page_count = 0; page_count < kPoolPagesMax; ++page_count) {
    absl::StatusOr<v1::ListPoolsResponse> page =
        CallUnary(call_options_, pools_.get(), &v1::PoolService::Stub::AsyncListPools, request);
    if (!page.ok()) {
      return page.status();
    }
    for (const v1::Pool& pool : page->pools()) {
      if (absl::Status status = ValidatePool(pool, pool.name()); !status.ok()) {
        return status;
      }
      pools.push_back(pool);
    }
    request.set_page_token(page->next_page_token());
    if (request.page_token().empty()) {
      return pools;
    }
  }
  return absl::InternalError(absl::StrCat("the server's answer: a list of pools with more than ",
                                          kPoolPagesMax, " pages, expected: an end"));
}

absl::Status Client::DeletePool(const std::string& name) {
  v1::DeletePoolRequest request;
  request.set_name(name);
  return CallUnary(call_options_, pools_.get(), &v1::PoolService::Stub::AsyncDeletePool, request)
      .status();
}

absl::StatusOr<v1::Pool> Client::RenewPool(const std::string& name,
                                           std::optional<absl::Duration> lease_duration) {
  v1::RenewPoolRequest request;
  request.set_name(name);
  if (lease_duration.has_value()) {
    const timespec duration = absl::ToTimespec(*lease_duration);
    request.mutable_lease_duration()->set_seconds(duration.tv_sec);
    request.mutable_lease_duration()->set_nanos(static_cast<int32_t>(duration.tv_nsec));
  }
  auto pool =
      CallUnary(call_options_, pools_.get(), &v1::PoolService::Stub::AsyncRenewPool, request);
  absl::Status status = pool.ok() ? ValidatePool(*pool, name) : pool.status();
  return IfValid(std::move(pool), std::move(status));
}

absl::StatusOr<std::unique_ptr<StepStream>> Client::Attach(const std::string& pool,
                                                           const StreamOptions& options) {
  std::unique_ptr<StepStream> stream(new StepStream(step_.get(), call_options_, pool, options));
  if (absl::Status status = stream->Attach(); !status.ok()) {
    return status;
  }
  return stream;
}

absl::StatusOr<std::vector<v1::State>> Client::SaveStates(const std::string& pool,
                                                          absl::Span<const int32_t> environments,
                                                          int64_t response_bytes_max) {
  std::vector<v1::State> states;
  v1::SaveStatesRequest request;
  request.set_pool(pool);
  request.mutable_environments()->Add(environments.begin(), environments.end());
  request.set_response_bytes_max(response_bytes_max);
  do {
    absl::StatusOr<v1::SaveStatesResponse> page =
        CallUnary(call_options_, states_.get(), &v1::StateService::Stub::AsyncSaveStates, request);
    if (!page.ok()) {
      return page.status();
    }
    if (absl::Status status = ValidateStates(*page, environments, states.size()); !status.ok()) {
      return status;
    }
    for (v1::State& state : *page->mutable_states()) {
      states.push_back(std::move(state));
    }
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return states;
}

absl::Status Client::RestoreStates(const std::string& pool, absl::Span<const v1::State> states) {
  v1::RestoreStatesRequest request;
  request.set_pool(pool);
  const auto empty_bytes = static_cast<int64_t>(request.ByteSizeLong());
  request.mutable_states()->Add(states.begin(), states.end());
  if (static_cast<int64_t>(request.ByteSizeLong()) <= kRequestBytesAlways) {
    return Restore(request);
  }
  const absl::StatusOr<v1::Catalog> catalog = GetCatalog();
  if (!catalog.ok()) {
    return catalog.status();
  }
  request.clear_states();
  int64_t bytes = empty_bytes;
  for (const v1::State& state : states) {
    const int64_t state_bytes = static_cast<int64_t>(state.ByteSizeLong()) + kStateOverheadBytes;
    if (!request.states().empty() && bytes + state_bytes > catalog->limits().request_bytes_max()) {
      if (absl::Status status = Restore(request); !status.ok()) {
        return status;
      }
      request.clear_states();
      bytes = empty_bytes;
    }
    *request.add_states() = state;
    bytes += state_bytes;
  }
  return Restore(request);
}

absl::Status Client::Restore(const v1::RestoreStatesRequest& request) {
  return CallUnary(call_options_, states_.get(), &v1::StateService::Stub::AsyncRestoreStates,
                   request)
      .status();
}

absl::Status Client::CloneStates(const std::string& pool, absl::Span<const v1::ClonePair> pairs,
                                 const CloneSource& source) {
  v1::CloneStatesRequest request;
  request.set_pool(pool);
  request.set_source_pool(source.pool);
  request.set_source_server(source.server);
  request.mutable_pairs()->Add(pairs.begin(), pairs.end());
  return CallUnary(call_options_, states_.get(), &v1::StateService::Stub::AsyncCloneStates, request)
      .status();
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
  auto episode =
      CallUnary(call_options_, states_.get(), &v1::StateService::Stub::AsyncGetEpisode, request);
  absl::Status status =
      episode.ok() ? ValidateEpisode(*episode, request.environment()) : episode.status();
  return IfValid(std::move(episode), std::move(status));
}

absl::StatusOr<v1::RenderEnvironmentsResponse> Client::RenderEnvironments(
    const std::string& pool, absl::Span<const int32_t> environments, int32_t size_px,
    v1::FrameFormat format, v1::FrameView view) {
  v1::RenderEnvironmentsRequest request;
  request.set_pool(pool);
  request.mutable_environments()->Add(environments.begin(), environments.end());
  request.set_size_px(size_px);
  request.set_format(format);
  request.set_view(view);
  auto rendered = CallUnary(call_options_, render_.get(),
                            &v1::RenderService::Stub::AsyncRenderEnvironments, request);
  absl::Status status = rendered.ok()
                            ? ValidateFrames(rendered->frames(), environments, size_px, format)
                            : rendered.status();
  return IfValid(std::move(rendered), std::move(status));
}

std::unique_ptr<PoolWatch> Client::Watch(const v1::WatchPoolRequest& request) {
  return std::make_unique<PoolWatch>(
      call_options_.token,
      [&](grpc::ClientContext* context) { return render_->WatchPool(context, request); },
      [environments =
           std::vector<int32_t>(request.environments().begin(), request.environments().end()),
       size_px = request.size_px(),
       format = request.format()](const v1::WatchPoolResponse& response) {
        return ValidateFrames(response.frames(), environments, size_px, format);
      });
}

}  // namespace procgen_client
