#include "procgen_client/client.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "procgen_client/grpc_error.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

// Calls a unary method and returns its response.
template <typename Stub, typename Request, typename Response>
absl::StatusOr<Response> CallUnary(Stub* stub,
                                   grpc::Status (Stub::*method)(grpc::ClientContext*,
                                                                const Request&, Response*),
                                   const Request& request) {
  grpc::ClientContext context;
  Response response;
  if (const grpc::Status status = (stub->*method)(&context, request, &response); !status.ok()) {
    return ToAbslStatus(status);
  }
  return response;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Client>> Client::Connect(const std::string& address,
                                                        const ConnectOptions& options) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(options.response_bytes_max);
  const std::shared_ptr<grpc::Channel> channel =
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  if (!channel->WaitForConnected(absl::ToChronoTime(absl::Now() + options.timeout))) {
    return absl::UnavailableError(absl::StrCat("no server answers at ", address, " within ",
                                               absl::FormatDuration(options.timeout)));
  }
  return std::unique_ptr<Client>(new Client(channel));
}

Client::Client(const std::shared_ptr<grpc::Channel>& channel)
    : catalog_(v1::CatalogService::NewStub(channel)),
      pools_(v1::PoolService::NewStub(channel)),
      step_(v1::StepService::NewStub(channel)),
      render_(v1::RenderService::NewStub(channel)) {}

absl::StatusOr<v1::Catalog> Client::GetCatalog() {
  return CallUnary(catalog_.get(), &v1::CatalogService::Stub::GetCatalog, v1::GetCatalogRequest());
}

absl::StatusOr<v1::Load> Client::GetLoad() {
  return CallUnary(catalog_.get(), &v1::CatalogService::Stub::GetLoad, v1::GetLoadRequest());
}

absl::StatusOr<v1::Pool> Client::CreatePool(const v1::PoolSpec& spec, const std::string& pool_id) {
  v1::CreatePoolRequest request;
  request.set_pool_id(pool_id);
  *request.mutable_spec() = spec;
  return CallUnary(pools_.get(), &v1::PoolService::Stub::CreatePool, request);
}

absl::StatusOr<v1::Pool> Client::GetPool(const std::string& name) {
  v1::GetPoolRequest request;
  request.set_name(name);
  return CallUnary(pools_.get(), &v1::PoolService::Stub::GetPool, request);
}

absl::StatusOr<std::vector<v1::Pool>> Client::ListPools() {
  std::vector<v1::Pool> pools;
  v1::ListPoolsRequest request;
  do {
    absl::StatusOr<v1::ListPoolsResponse> page =
        CallUnary(pools_.get(), &v1::PoolService::Stub::ListPools, request);
    if (!page.ok()) {
      return page.status();
    }
    pools.insert(pools.end(), page->pools().begin(), page->pools().end());
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return pools;
}

absl::Status Client::DeletePool(const std::string& name) {
  v1::DeletePoolRequest request;
  request.set_name(name);
  return CallUnary(pools_.get(), &v1::PoolService::Stub::DeletePool, request).status();
}

absl::StatusOr<std::unique_ptr<StepStream>> Client::Attach(const std::string& pool,
                                                           const StreamOptions& options) {
  std::unique_ptr<StepStream> stream(new StepStream());
  if (absl::Status status = stream->Attach(step_.get(), pool, options); !status.ok()) {
    return status;
  }
  return stream;
}

absl::StatusOr<v1::RenderEnvironmentsResponse> Client::RenderEnvironments(
    const std::string& pool, absl::Span<const int32_t> environments, int32_t side_px) {
  v1::RenderEnvironmentsRequest request;
  request.set_pool(pool);
  request.mutable_environments()->Add(environments.begin(), environments.end());
  request.set_side_px(side_px);
  return CallUnary(render_.get(), &v1::RenderService::Stub::RenderEnvironments, request);
}

}  // namespace procgen_client
