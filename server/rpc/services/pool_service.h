#ifndef SERVER_RPC_SERVICES_POOL_SERVICE_H_
#define SERVER_RPC_SERVICES_POOL_SERVICE_H_

#include "server/rpc/auth/caller.h"
#include "server/rpc/call/byte_service.h"
#include "server/session/sessions.h"

namespace procgen {

// PoolService: makes, finds and ends pools.
class PoolServiceImpl final : public ByteService {
 public:
  // `sessions` and `callers` must outlive this.
  PoolServiceImpl(Sessions* sessions, const Callers* callers);

 private:
  ByteStream* CreatePool(grpc::CallbackServerContext* context);
  ByteStream* GetPool(grpc::CallbackServerContext* context);
  ByteStream* ListPools(grpc::CallbackServerContext* context);
  ByteStream* DeletePool(grpc::CallbackServerContext* context);
  ByteStream* RenewPool(grpc::CallbackServerContext* context);

  Sessions* const sessions_;
  const Callers* const callers_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_POOL_SERVICE_H_
