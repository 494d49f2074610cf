#ifndef SERVER_RPC_DM_ENV_RPC_DM_ENV_RPC_SERVICE_H_
#define SERVER_RPC_DM_ENV_RPC_DM_ENV_RPC_SERVICE_H_

#include <cstddef>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "server/dm_env_rpc/joined_world.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/dm_env_rpc/dm_env_rpc_reactor.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// The service of dm_env_rpc: each stream is a DmEnvRpcReactor.
class DmEnvRpcServiceImpl final : public ByteService {
 public:
  // `supervisor` and `accounting` must outlive this.
  DmEnvRpcServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting);

  // Ends all current and future streams with UNAVAILABLE. PoolSupervisor::Drain reaches only
  // streams that have joined a world.
  void Drain();

 private:
  static constexpr size_t kStreamsKeptMin = 64;

  ByteStream* Process(grpc::CallbackServerContext* context);
  void RemoveEnded() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  JoinedWorlds worlds_;

  absl::Mutex mutex_;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  // All current streams, and some ended ones, which are removed when there are many.
  std::vector<std::weak_ptr<DmEnvRpcReactor>> streams_ ABSL_GUARDED_BY(mutex_);
  size_t streams_kept_max_ ABSL_GUARDED_BY(mutex_) = kStreamsKeptMin;
};

}  // namespace procgen

#endif  // SERVER_RPC_DM_ENV_RPC_DM_ENV_RPC_SERVICE_H_
