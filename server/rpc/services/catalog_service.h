#ifndef SERVER_RPC_SERVICES_CATALOG_SERVICE_H_
#define SERVER_RPC_SERVICES_CATALOG_SERVICE_H_

#include "procgen/v1/catalog.grpc.pb.h"
#include "server/pool/pool_supervisor.h"
#include "server/rpc/auth/call_accounting.h"

namespace procgen {

// CatalogService: returns the load and the catalog, which is built once in the constructor.
class CatalogServiceImpl final : public v1::CatalogService::CallbackService {
 public:
  // `supervisor` and `accounting` must outlive this.
  CatalogServiceImpl(const PoolSupervisor* supervisor, const CallAccounting* accounting);

  grpc::ServerUnaryReactor* GetCatalog(grpc::CallbackServerContext* context,
                                       const v1::GetCatalogRequest* request,
                                       v1::Catalog* response) override;
  grpc::ServerUnaryReactor* GetLoad(grpc::CallbackServerContext* context,
                                    const v1::GetLoadRequest* request, v1::Load* response) override;

 private:
  const PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  const v1::Catalog catalog_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_CATALOG_SERVICE_H_
