#ifndef SERVER_RPC_STEP_STEP_SERVICE_H_
#define SERVER_RPC_STEP_STEP_SERVICE_H_

#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/session/pool_supervisor.h"
#include "server/shared_memory/pipe_listener.h"

namespace procgen {

// StepService: each stream is a StepPoolReactor.
class StepServiceImpl final : public ByteService {
 public:
  // `pipe_listener`: for pools that share memory; null: pipes are not offered. All pointers must
  // outlive this.
  StepServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting,
                  PipeListener* pipe_listener);

 private:
  ByteStream* StepPool(grpc::CallbackServerContext* context);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  PipeListener* const pipe_listener_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_STEP_SERVICE_H_
