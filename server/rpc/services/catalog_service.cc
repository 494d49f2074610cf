#include "server/rpc/services/catalog_service.h"

#include <string>

#include "server/wire/convert_catalog.h"

namespace procgen {

CatalogServiceImpl::CatalogServiceImpl(const PoolSupervisor* supervisor,
                                       const CallAccounting* accounting)
    : supervisor_(supervisor),
      accounting_(accounting),
      catalog_(CatalogMessageOf(
          {.version = PROCGEN_SERVER_VERSION, .has_own_art = supervisor->art() != nullptr},
          supervisor->limits())) {}

grpc::ServerUnaryReactor* CatalogServiceImpl::GetCatalog(grpc::CallbackServerContext* context,
                                                         const v1::GetCatalogRequest* /*request*/,
                                                         v1::Catalog* response) {
  return accounting_->Answer(context, "CatalogService/GetCatalog",
                             [&](const std::string& /*owner*/) {
                               *response = catalog_;
                               return absl::OkStatus();
                             });
}

grpc::ServerUnaryReactor* CatalogServiceImpl::GetLoad(grpc::CallbackServerContext* context,
                                                      const v1::GetLoadRequest* /*request*/,
                                                      v1::Load* response) {
  return accounting_->Answer(context, "CatalogService/GetLoad", [&](const std::string& /*owner*/) {
    *response = LoadMessageOf(supervisor_->load(), supervisor_->metrics().stream_totals());
    return absl::OkStatus();
  });
}

}  // namespace procgen
