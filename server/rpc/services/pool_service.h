#ifndef SERVER_RPC_SERVICES_POOL_SERVICE_H_
#define SERVER_RPC_SERVICES_POOL_SERVICE_H_

#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// PoolService: creates, returns, lists, renews and deletes pools.
class PoolServiceImpl final : public ByteService {
 public:
  // `supervisor` and `accounting` must outlive this.
  PoolServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting);

 private:
  ByteStream* CreatePool(grpc::CallbackServerContext* context);
  ByteStream* GetPool(grpc::CallbackServerContext* context);
  ByteStream* ListPools(grpc::CallbackServerContext* context);
  ByteStream* DeletePool(grpc::CallbackServerContext* context);
  ByteStream* RenewPool(grpc::CallbackServerContext* context);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_POOL_SERVICE_H_
