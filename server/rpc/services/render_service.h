#ifndef SERVER_RPC_SERVICES_RENDER_SERVICE_H_
#define SERVER_RPC_SERVICES_RENDER_SERVICE_H_

#include "server/rpc/auth/caller.h"
#include "server/rpc/call/byte_service.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// RenderService: draws environments for people.
class RenderServiceImpl final : public ByteService {
 public:
  // `supervisor` and `callers` must outlive this.
  RenderServiceImpl(PoolSupervisor* supervisor, const Callers* callers);

 private:
  ByteStream* RenderEnvironments(grpc::CallbackServerContext* context);
  ByteStream* WatchPool(grpc::CallbackServerContext* context);

  PoolSupervisor* const supervisor_;
  const Callers* const callers_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_RENDER_SERVICE_H_
