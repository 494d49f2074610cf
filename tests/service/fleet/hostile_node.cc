#include "tests/service/fleet/hostile_node.h"

#include <initializer_list>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "grpcpp/grpcpp.h"

namespace procgen {
namespace {

// Forwards a call of the proxy to `method` of `stub`.
template <typename Stub, typename Request, typename Response>
grpc::Status Forward(Stub* stub,
                     grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                     const grpc::ServerContext& call, const Request& request, Response* response) {
  const std::unique_ptr<grpc::ClientContext> context = grpc::ClientContext::FromServerContext(call);
  return (stub->*method)(context.get(), request, response);
}

}  // namespace

class HostileNode::Catalogs final : public v1::CatalogService::Service {
 public:
  Catalogs(HostileNode* node, const std::shared_ptr<grpc::Channel>& target)
      : node_(node), target_(v1::CatalogService::NewStub(target)) {}

  grpc::Status GetCatalog(grpc::ServerContext* context, const v1::GetCatalogRequest* request,
                          v1::Catalog* response) override {
    grpc::Status status =
        Forward(target_.get(), &v1::CatalogService::Stub::GetCatalog, *context, *request, response);
    node_->Apply(node_->damage_.catalog, response);
    return status;
  }
  grpc::Status GetLoad(grpc::ServerContext* context, const v1::GetLoadRequest* request,
                       v1::Load* response) override {
    return Forward(target_.get(), &v1::CatalogService::Stub::GetLoad, *context, *request, response);
  }

 private:
  HostileNode* const node_;
  const std::unique_ptr<v1::CatalogService::Stub> target_;
};

class HostileNode::Pools final : public v1::PoolService::Service {
 public:
  Pools(HostileNode* node, const std::shared_ptr<grpc::Channel>& target)
      : node_(node), target_(v1::PoolService::NewStub(target)) {}

  grpc::Status CreatePool(grpc::ServerContext* context, const v1::CreatePoolRequest* request,
                          v1::Pool* response) override {
    grpc::Status status =
        Forward(target_.get(), &v1::PoolService::Stub::CreatePool, *context, *request, response);
    node_->Apply(node_->damage_.pool, response);
    return status;
  }
  grpc::Status ListPools(grpc::ServerContext* context, const v1::ListPoolsRequest* request,
                         v1::ListPoolsResponse* response) override {
    return Forward(target_.get(), &v1::PoolService::Stub::ListPools, *context, *request, response);
  }
  grpc::Status DeletePool(grpc::ServerContext* context, const v1::DeletePoolRequest* request,
                          google::protobuf::Empty* response) override {
    return Forward(target_.get(), &v1::PoolService::Stub::DeletePool, *context, *request, response);
  }

 private:
  HostileNode* const node_;
  const std::unique_ptr<v1::PoolService::Stub> target_;
};

class HostileNode::Steps final : public v1::StepService::Service {
 public:
  Steps(HostileNode* node, const std::shared_ptr<grpc::Channel>& target)
      : node_(node), target_(v1::StepService::NewStub(target)) {}

  grpc::Status StepPool(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::StepPoolResponse, v1::StepPoolRequest>* learner) override {
    const std::unique_ptr<grpc::ClientContext> call =
        grpc::ClientContext::FromServerContext(*context);
    const auto stream = target_->StepPool(call.get());
    v1::StepPoolRequest request;
    v1::StepPoolResponse response;
    bool is_open = true;
    while (is_open && learner->Read(&request) && stream->Write(request)) {
      bool is_last = false;
      while (!is_last && (is_open = stream->Read(&response))) {
        is_last = !response.has_batch() || response.batch().last();
        node_->Apply(request.has_attach() ? node_->damage_.attached : node_->damage_.step,
                     &response);
        learner->Write(response);
      }
    }
    stream->WritesDone();
    return stream->Finish();
  }

 private:
  HostileNode* const node_;
  const std::unique_ptr<v1::StepService::Stub> target_;
};

class HostileNode::States final : public v1::StateService::Service {
 public:
  States(HostileNode* node, const std::shared_ptr<grpc::Channel>& target)
      : node_(node), target_(v1::StateService::NewStub(target)) {}

  grpc::Status SaveStates(grpc::ServerContext* context, const v1::SaveStatesRequest* request,
                          v1::SaveStatesResponse* response) override {
    grpc::Status status =
        Forward(target_.get(), &v1::StateService::Stub::SaveStates, *context, *request, response);
    node_->Apply(node_->damage_.states, response);
    return status;
  }
  grpc::Status RestoreStates(grpc::ServerContext* context, const v1::RestoreStatesRequest* request,
                             v1::RestoreStatesResponse* response) override {
    return Forward(target_.get(), &v1::StateService::Stub::RestoreStates, *context, *request,
                   response);
  }

 private:
  HostileNode* const node_;
  const std::unique_ptr<v1::StateService::Stub> target_;
};

class HostileNode::Renders final : public v1::RenderService::Service {
 public:
  Renders(HostileNode* node, const std::shared_ptr<grpc::Channel>& target)
      : node_(node), target_(v1::RenderService::NewStub(target)) {}

  grpc::Status RenderEnvironments(grpc::ServerContext* context,
                                  const v1::RenderEnvironmentsRequest* request,
                                  v1::RenderEnvironmentsResponse* response) override {
    grpc::Status status = Forward(target_.get(), &v1::RenderService::Stub::RenderEnvironments,
                                  *context, *request, response);
    node_->Apply(node_->damage_.frames, response);
    return status;
  }

 private:
  HostileNode* const node_;
  const std::unique_ptr<v1::RenderService::Stub> target_;
};

HostileNode::HostileNode(const std::string& target, AnswerDamage damage)
    : damage_(std::move(damage)) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const std::shared_ptr<grpc::Channel> channel =
      grpc::CreateCustomChannel(target, grpc::InsecureChannelCredentials(), arguments);
  catalogs_ = std::make_unique<Catalogs>(this, channel);
  pools_ = std::make_unique<Pools>(this, channel);
  steps_ = std::make_unique<Steps>(this, channel);
  states_ = std::make_unique<States>(this, channel);
  renders_ = std::make_unique<Renders>(this, channel);
  grpc::ServerBuilder builder;
  builder.SetMaxReceiveMessageSize(-1);
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  for (grpc::Service* service : std::initializer_list<grpc::Service*>{
           catalogs_.get(), pools_.get(), steps_.get(), states_.get(), renders_.get()}) {
    builder.RegisterService(service);
  }
  // Clients send keepalive pings more often than gRPC's default limit allows.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 100);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PING_STRIKES, 0);
  server_ = builder.BuildAndStart();
  address_ = absl::StrCat("127.0.0.1:", port);
}

HostileNode::~HostileNode() { server_->Shutdown(absl::ToChronoTime(absl::Now())); }

}  // namespace procgen
