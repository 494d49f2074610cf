#include "server/rpc/services/catalog_service.h"

#include "server/rpc/call/unary_call.h"
#include "server/wire/convert_catalog.h"

namespace procgen {

CatalogServiceImpl::CatalogServiceImpl(const PoolSupervisor* supervisor,
                                       const CallAccounting* accounting)
    : supervisor_(supervisor),
      accounting_(accounting),
      catalog_(CatalogMessageOf({.version = PROCGEN_SERVER_VERSION,
                                 .has_own_art = supervisor->art() != nullptr,
                                 .shares_memory = supervisor->shares_memory()},
                                supervisor->limits())) {
  AddByteMethod<v1::GetCatalogRequest>([this](auto* context) { return GetCatalog(context); });
  AddByteMethod<v1::GetLoadRequest>([this](auto* context) { return GetLoad(context); });
}

ByteStream* CatalogServiceImpl::GetCatalog(grpc::CallbackServerContext* context) {
  using Call = UnaryCall<v1::GetCatalogRequest, v1::Catalog>;
  return Call::Start(*accounting_, *context, [this](Call* call) {
    *call->response() = catalog_;
    call->Finish(absl::OkStatus());
  });
}

ByteStream* CatalogServiceImpl::GetLoad(grpc::CallbackServerContext* context) {
  using Call = UnaryCall<v1::GetLoadRequest, v1::Load>;
  return Call::Start(*accounting_, *context, [this](Call* call) {
    *call->response() = LoadMessageOf(supervisor_->load(), supervisor_->metrics().stream_totals());
    call->Finish(absl::OkStatus());
  });
}

}  // namespace procgen
