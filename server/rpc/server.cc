#include "server/rpc/server.h"

#include <algorithm>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "grpcpp/ext/proto_server_reflection_plugin.h"
#include "grpcpp/grpcpp.h"
#include "grpcpp/health_check_service_interface.h"
#include "server/rpc/catalog_service.h"
#include "server/rpc/pool_service.h"
#include "server/rpc/render_service.h"
#include "server/rpc/state_service.h"
#include "server/rpc/step_service.h"
#include "server/session/sessions.h"

namespace procgen {
namespace {

// How often a stopping server looks whether its streams have ended.
constexpr absl::Duration kDrainPoll = absl::Milliseconds(10);

std::string BoundAddress(const std::string& address, int port) {
  if (absl::StartsWith(address, "unix:")) {
    return address;
  }
  return absl::StrCat(address.substr(0, address.rfind(':')), ":", port);
}

class GrpcServer final : public Server {
 public:
  explicit GrpcServer(const ServerOptions& options)
      : tls_(options.tls),
        sessions_(options.limits, options.worker_count, options.art),
        callers_(options.tokens, tls_ != nullptr && tls_->asks_clients(), &sessions_.owners()),
        catalog_service_(&sessions_, &callers_),
        pool_service_(&sessions_, &callers_),
        step_service_(&sessions_, &callers_),
        state_service_(&sessions_, &callers_, options.clone_sources),
        render_service_(&sessions_, &callers_) {}

  ~GrpcServer() override { Stop(absl::ZeroDuration()); }

  absl::Status Listen(const ServerOptions& options) {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort(
        options.address,
        tls_ == nullptr ? grpc::InsecureServerCredentials() : tls_->MakeServerCredentials(), &port);
    // Two servers on one port would each get some of the connections.
    builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
    builder.SetMaxReceiveMessageSize(static_cast<int>(options.limits.request_bytes_max));
    builder.SetMaxSendMessageSize(-1);
    for (grpc::Service* service :
         std::initializer_list<grpc::Service*>{&catalog_service_, &pool_service_, &step_service_,
                                               &state_service_, &render_service_}) {
      builder.RegisterService(service);
    }
    server_ = builder.BuildAndStart();
    if (server_ == nullptr || (port == 0 && !absl::StartsWith(options.address, "unix:"))) {
      return absl::UnavailableError(absl::StrCat("cannot listen on ", options.address));
    }
    address_ = BoundAddress(options.address, port);
    for (const char* service :
         {v1::CatalogService::service_full_name(), v1::PoolService::service_full_name(),
          v1::StepService::service_full_name(), v1::StateService::service_full_name(),
          v1::RenderService::service_full_name()}) {
      server_->GetHealthCheckService()->SetServingStatus(service, true);
    }
    server_->GetHealthCheckService()->SetServingStatus(true);
    return absl::OkStatus();
  }

  const std::string& address() const override { return address_; }

  void BeginDrain() override {
    server_->GetHealthCheckService()->SetServingStatus(false);
    sessions_.Drain();
  }

  void Stop(absl::Duration deadline) override {
    if (server_ == nullptr) {
      return;
    }
    const absl::Time end = absl::Now() + deadline;
    BeginDrain();
    while (sessions_.load().stream_count > 0 && absl::Now() < end) {
      absl::SleepFor(std::min(kDrainPoll, end - absl::Now()));
    }
    server_->Shutdown(absl::ToChronoTime(end));
    server_->Wait();
  }

 private:
  const std::shared_ptr<TlsFiles> tls_;  // before server_, which reads it with each connection
  std::string address_;
  Sessions sessions_;
  const Callers callers_;
  CatalogServiceImpl catalog_service_;
  PoolServiceImpl pool_service_;
  StepServiceImpl step_service_;
  StateServiceImpl state_service_;
  RenderServiceImpl render_service_;
  std::unique_ptr<grpc::Server> server_;
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
