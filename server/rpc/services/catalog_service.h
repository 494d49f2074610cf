#ifndef SERVER_RPC_SERVICES_CATALOG_SERVICE_H_
#define SERVER_RPC_SERVICES_CATALOG_SERVICE_H_

#include "procgen/v1/catalog.pb.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// CatalogService: returns the load and the catalog, which is built once in the constructor.
class CatalogServiceImpl final : public ByteService {
 public:
  // `supervisor` and `accounting` must outlive this.
  CatalogServiceImpl(const PoolSupervisor* supervisor, const CallAccounting* accounting);

 private:
  ByteStream* GetCatalog(grpc::CallbackServerContext* context);
  ByteStream* GetLoad(grpc::CallbackServerContext* context);

  const PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  const v1::Catalog catalog_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_CATALOG_SERVICE_H_
