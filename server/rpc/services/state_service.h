#ifndef SERVER_RPC_SERVICES_STATE_SERVICE_H_
#define SERVER_RPC_SERVICES_STATE_SERVICE_H_

#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/services/clone_source_allowlist.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// StateService: saves, restores and clones environments, and returns their episodes. Each runs in a
// turn of the pool and on the background executor. A call has one turn at a time, so calls between
// the same pools cannot deadlock. Also serves during a drain.
class StateServiceImpl final : public ByteService {
 public:
  // `supervisor` and `accounting` must outlive this.
  // `clone_source_allowlist`: the servers that CloneStates may connect to.
  StateServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting,
                   CloneSourceAllowlist clone_source_allowlist);

 private:
  ByteStream* SaveStates(grpc::CallbackServerContext* context);
  ByteStream* RestoreStates(grpc::CallbackServerContext* context);
  ByteStream* CloneStates(grpc::CallbackServerContext* context);
  ByteStream* GetEpisode(grpc::CallbackServerContext* context);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  const CloneSourceAllowlist clone_source_allowlist_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_STATE_SERVICE_H_
