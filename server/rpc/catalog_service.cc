#include "server/rpc/catalog_service.h"

#include "server/rpc/convert_catalog.h"
#include "server/rpc/unary_call.h"

namespace procgen {

CatalogServiceImpl::CatalogServiceImpl(const Sessions* sessions, const Callers* callers)
    : sessions_(sessions),
      callers_(callers),
      catalog_(CatalogMessageOf(PROCGEN_SERVER_VERSION, sessions->limits(),
                                sessions->art() != nullptr)) {}

grpc::ServerUnaryReactor* CatalogServiceImpl::GetCatalog(grpc::CallbackServerContext* context,
                                                         const grpc::ByteBuffer* request,
                                                         grpc::ByteBuffer* response) {
  using Call = UnaryCall<v1::GetCatalogRequest, v1::Catalog>;
  return Call::Start(*callers_, *context, request, response, [this](Call* call) {
    *call->response() = catalog_;
    call->Finish(absl::OkStatus());
  });
}

grpc::ServerUnaryReactor* CatalogServiceImpl::GetLoad(grpc::CallbackServerContext* context,
                                                      const grpc::ByteBuffer* request,
                                                      grpc::ByteBuffer* response) {
  using Call = UnaryCall<v1::GetLoadRequest, v1::Load>;
  return Call::Start(*callers_, *context, request, response, [this](Call* call) {
    *call->response() = LoadMessageOf(sessions_->load(), sessions_->metrics().stream_totals());
    call->Finish(absl::OkStatus());
  });
}

}  // namespace procgen
