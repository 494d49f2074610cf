#include "server/rpc/server.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "grpc/grpc.h"
#include "grpc/support/log.h"
#include "grpc/support/time.h"
#include "grpcpp/ext/proto_server_reflection_plugin.h"
#include "grpcpp/grpcpp.h"
#include "grpcpp/health_check_service_interface.h"
#include "server/logging/event_log.h"
#include "server/net/address.h"
#include "server/net/listener.h"
#include "server/pool/pool_supervisor.h"
#include "server/rpc/auth/authenticator.h"
#include "server/rpc/auth/tls_credentials.h"
#include "server/rpc/bridge/generic_stub.h"
#include "server/rpc/node_reporter.h"
#include "server/rpc/services/catalog_service.h"
#include "server/rpc/services/cluster_service.h"
#include "server/rpc/services/pool_service.h"

namespace procgen {
namespace {

// Interval at which a stopping server checks whether all calls have ended.
constexpr absl::Duration kDrainPoll = absl::Milliseconds(10);
// Time that idle clients have to close their connections at a stop. gRPC's C++ client checks an
// idle connection only every five seconds.
constexpr absl::Duration kConnectionCloseTimeout = absl::Milliseconds(200);

// Threads of gRPC's reflection service, which takes one for each stream and needs no token. Streams
// beyond them get RESOURCE_EXHAUSTED.
constexpr int kReflectionThreadCount = 4;

// Concurrent calls allowed on a connection.
constexpr int kConnectionCallsMax = 4096;
// Time for the handshakes of a new connection (TLS and HTTP/2), and time without calls after which
// a connection is closed.
constexpr absl::Duration kHandshakeTimeout = absl::Seconds(10);
constexpr absl::Duration kIdleTimeout = absl::Minutes(10);
// Bytes that gRPC reads and parses at a time, so at most before it notices a shutdown.
constexpr int kReadBytesMax = 64 << 10;
// Bytes of a stream that are sent to a page's call before it reads them.
constexpr int kStubWindowBytes = 64 << 10;
// Shortest allowed interval between keepalive pings of a client.
constexpr absl::Duration kPingIntervalMin = absl::Milliseconds(100);

std::string WithPort(const std::string& address, uint16_t port) {
  if (absl::StartsWith(address, "unix:")) {
    return address;
  }
  return absl::StrCat(address.substr(0, address.rfind(':')), ":", port);
}

// Returns the address at which clients reach a server that listens on `bound`.
std::string AdvertisedAddress(const std::string& advertised, const std::string& bound,
                              uint16_t port) {
  if (advertised.empty()) {
    return bound;
  }
  return absl::EndsWith(advertised, ":0") ? WithPort(advertised, port) : advertised;
}

// Redirects gRPC's log lines to the server's log. On its own gRPC would block if nothing reads
// standard error, and clients can cause lines, for example by failed handshakes.
void LogGrpcLine(gpr_log_func_args* line) {
  const LogLevel level = line->severity == GPR_LOG_SEVERITY_ERROR  ? LogLevel::kError
                         : line->severity == GPR_LOG_SEVERITY_INFO ? LogLevel::kInfo
                                                                   : LogLevel::kDebug;
  LogEvent(level, "grpc",
           {{"source", absl::StrCat(line->file, ":", line->line)}, {"message", line->message}});
}

int Milliseconds(absl::Duration duration) {
  return static_cast<int>(absl::ToInt64Milliseconds(duration));
}

void SetKeepalive(const ServerOptions& options, grpc::ServerBuilder* builder) {
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, Milliseconds(options.keepalive_time));
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS,
                              Milliseconds(options.keepalive_timeout));
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  // Unlimited, because a learner may send no data for long.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // Clients may ping, too; by default gRPC closes the connection of one that pings often.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                              Milliseconds(kPingIntervalMin));
}

class GrpcServer final : public Server {
 public:
  explicit GrpcServer(const ServerOptions& options)
      : tls_(options.tls != nullptr ? std::make_unique<TlsCredentials>(options.tls) : nullptr),
        supervisor_(options.limits, options.worker_count, &metrics_, options.art),
        accounting_(Authenticator(options.tokens, options.tls != nullptr &&
                                                      options.tls->requires_client_certificate()),
                    &supervisor_.quotas(), &metrics_),
        cluster_(options.cluster != nullptr ? options.cluster
                                            : Cluster::Alone(ClusterOptions().node_id)),
        catalog_service_(&supervisor_, &accounting_),
        cluster_service_(cluster_.get(), &accounting_),
        pool_service_(&supervisor_, &accounting_) {
    metrics_.ReadGaugesFrom([this] { return supervisor_.load(); });
  }

  ~GrpcServer() override { Stop(absl::ZeroDuration()); }

  absl::Status Listen(const ServerOptions& options) {
    gpr_set_log_function(LogGrpcLine);
    // Without its grpc_shutdown, which waits indefinitely if gRPC ever failed to start a thread.
    grpc_init();
    const absl::StatusOr<Address> address = ParseAddress(options.address);
    if (!address.ok()) {
      return address.status();
    }
    auto listener = Listener::Listen(*address);
    if (!listener.ok()) {
      return absl::UnavailableError(
          absl::StrCat("cannot listen on ", options.address, ": ", listener.status().message()));
    }
    grpc::ServerBuilder builder;
    Acceptor acceptor =
        AddAcceptor(tls_ == nullptr ? grpc::InsecureServerCredentials() : tls_->Make(), &builder);
    auto internal_listener = Listener::ListenInternal();
    if (!internal_listener.ok()) {
      return internal_listener.status();
    }
    Acceptor internal_acceptor = AddAcceptor(grpc::InsecureServerCredentials(), &builder);
    SetLimits(options.limits, &builder);
    SetKeepalive(options, &builder);
    for (grpc::Service* service : std::initializer_list<grpc::Service*>{
             &catalog_service_, &cluster_service_, &pool_service_}) {
      builder.RegisterService(service);
    }
    // gRPC's own health and reflection services.
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    server_ = builder.BuildAndStart();
    if (server_ == nullptr) {
      return absl::UnavailableError("gRPC cannot start a server");
    }
    listener_ = *std::move(listener);
    address_ = WithPort(options.address, listener_->port());
    advertised_address_ =
        AdvertisedAddress(options.advertised_address, address_, listener_->port());
    SetServing(true);
    internal_listener_ = *std::move(internal_listener);
    HandOver(std::move(acceptor), listener_.get());
    HandOver(std::move(internal_acceptor), internal_listener_.get());
    reporter_ = std::make_unique<NodeReporter>(cluster_.get(), [this] { return TakeSnapshot(); });
    return absl::OkStatus();
  }

  const std::string& address() const override { return address_; }
  const Metrics& metrics() const override { return metrics_; }

  std::unique_ptr<GenericStub> MakeStub() const override {
    grpc::ChannelArguments arguments;
    // The window of a stream, which gRPC otherwise enlarges by what the connection carries.
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kStubWindowBytes);
    arguments.SetMaxReceiveMessageSize(-1);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    // Not gRPC's in-process transport, which leaks streams that end while their client writes.
    return MakeGenericStub(grpc::CreateCustomChannel(
        internal_listener_->internal_target(), grpc::InsecureChannelCredentials(), arguments));
  }

  void BeginDrain() override {
    SetServing(false);
    supervisor_.Drain();
    reporter_->ReportNow();
  }

  void Stop(absl::Duration timeout) override {
    if (server_ == nullptr) {
      return;
    }
    const absl::Time end = SteadyNow() + timeout;
    BeginDrain();
    while (accounting_.CallCount() > 0 && SteadyNow() < end) {
      absl::SleepFor(std::min(kDrainPoll, end - SteadyNow()));
    }
    listener_.reset();
    internal_listener_.reset();
    const absl::Duration rest = std::min(end - SteadyNow(), kConnectionCloseTimeout);
    server_->Shutdown(
        gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC),
                     gpr_time_from_nanos(absl::ToInt64Nanoseconds(rest), GPR_TIMESPAN)));
    server_->Wait();
  }

 private:
  // Sets the status that the health service reports for the server and for each service.
  void SetServing(bool is_serving) {
    grpc::HealthCheckServiceInterface* const health = server_->GetHealthCheckService();
    health->SetServingStatus(is_serving);
    for (const char* service :
         {v1::CatalogService::service_full_name(), v1::ClusterService::service_full_name(),
          v1::PoolService::service_full_name()}) {
      health->SetServingStatus(service, is_serving);
    }
  }

  // Returns the state that is reported to the cluster.
  NodeReporter::Snapshot TakeSnapshot() const {
    const Load load = supervisor_.load();
    NodeStatus status;
    status.address = advertised_address_;
    status.server_version = PROCGEN_SERVER_VERSION;
    status.environment_capacity = static_cast<int32_t>(supervisor_.limits().env_count_max);
    status.env_count = load.env_count;
    status.pool_count = load.pool_count;
    status.worker_count = load.worker_count;
    status.healthy = !load.draining;  // as the health service says
    status.draining = load.draining;
    return {std::move(status), load.step_count};
  }

  using Acceptor = std::shared_ptr<grpc::experimental::ExternalConnectionAcceptor>;

  static Acceptor AddAcceptor(std::shared_ptr<grpc::ServerCredentials> credentials,
                              grpc::ServerBuilder* builder) {
    return builder->experimental().AddExternalConnectionAcceptor(
        grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
        std::move(credentials));
  }

  static void HandOver(Acceptor acceptor, Listener* listener) {
    listener->Start([acceptor = std::move(acceptor)](int listening, int connection) {
      grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
      parameters.listener_fd = listening;
      parameters.fd = connection;
      acceptor->HandleNewConnection(&parameters);
    });
  }

  // Sets the limits of unauthenticated clients and of messages.
  static void SetLimits(const Limits& limits, grpc::ServerBuilder* builder) {
    builder->SetMaxReceiveMessageSize(static_cast<int>(limits.request_bytes_max));
    builder->SetMaxSendMessageSize(-1);
    // gRPC limits the size of a message only before decompression, which can multiply it by 1000.
    for (const grpc_compression_algorithm algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
      builder->SetCompressionAlgorithmSupportStatus(algorithm, false);
    }
    builder->SetResourceQuota(grpc::ResourceQuota().SetMaxThreads(kReflectionThreadCount));
    builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kConnectionCallsMax);
    builder->AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS,
                                Milliseconds(kHandshakeTimeout));
    builder->AddChannelArgument(GRPC_ARG_TCP_MAX_READ_CHUNK_SIZE, kReadBytesMax);
    builder->AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, Milliseconds(kIdleTimeout));
  }

  const std::unique_ptr<TlsCredentials> tls_;  // null: plain text
  std::string address_;
  std::string advertised_address_;
  Metrics metrics_{PROCGEN_SERVER_VERSION};
  PoolSupervisor supervisor_;
  const CallAccounting accounting_;
  const std::shared_ptr<Cluster> cluster_;
  CatalogServiceImpl catalog_service_;
  ClusterServiceImpl cluster_service_;
  PoolServiceImpl pool_service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<Listener> listener_;  // hands its connections to server_
  std::unique_ptr<Listener> internal_listener_;
  std::unique_ptr<NodeReporter> reporter_;  // last, because it reads other members
};

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options) {
  auto server = std::make_unique<GrpcServer>(options);
  if (absl::Status status = server->Listen(options); !status.ok()) {
    return status;
  }
  return server;
}

}  // namespace procgen
