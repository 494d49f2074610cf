#ifndef SERVER_RPC_STEP_STEP_SERVICE_H_
#define SERVER_RPC_STEP_STEP_SERVICE_H_

#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/session/pool_supervisor.h"
#include "server/shared_memory/direct_lines.h"

namespace procgen {

// StepService: each stream is a StepPoolReactor.
class StepServiceImpl final : public ByteService {
 public:
  // `direct_lines`: of pools that share memory; null: none. What is pointed to must outlive this.
  StepServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting,
                  DirectLines* direct_lines);

 private:
  ByteStream* StepPool(grpc::CallbackServerContext* context);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  DirectLines* const direct_lines_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_STEP_SERVICE_H_
