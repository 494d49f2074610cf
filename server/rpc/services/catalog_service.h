#ifndef SERVER_RPC_SERVICES_CATALOG_SERVICE_H_
#define SERVER_RPC_SERVICES_CATALOG_SERVICE_H_

#include "procgen/v1/catalog.pb.h"
#include "server/rpc/auth/caller.h"
#include "server/rpc/call/byte_service.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// CatalogService: tells what there is. The catalog is written once, at the start.
class CatalogServiceImpl final : public ByteService {
 public:
  // `supervisor` and `callers` must outlive this.
  CatalogServiceImpl(const PoolSupervisor* supervisor, const Callers* callers);

 private:
  ByteStream* GetCatalog(grpc::CallbackServerContext* context);
  ByteStream* GetLoad(grpc::CallbackServerContext* context);

  const PoolSupervisor* const supervisor_;
  const Callers* const callers_;
  const v1::Catalog catalog_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_CATALOG_SERVICE_H_
