#ifndef SERVER_RPC_SERVICES_RENDER_SERVICE_H_
#define SERVER_RPC_SERVICES_RENDER_SERVICE_H_

#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// RenderService: renders environments, once or as a stream of frames.
class RenderServiceImpl final : public ByteService {
 public:
  // `supervisor` and `accounting` must outlive this.
  RenderServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting);

 private:
  ByteStream* RenderEnvironments(grpc::CallbackServerContext* context);
  ByteStream* WatchPool(grpc::CallbackServerContext* context);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_RENDER_SERVICE_H_
