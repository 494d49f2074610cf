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

  // Ends all streams with UNAVAILABLE, those that come later, too: also those that have joined no
  // world, of which nobody else knows.
  void Drain();

 private:
  static constexpr size_t kStreamsKeptMin = 64;

  ByteStream* Process(grpc::CallbackServerContext* context);
  void ForgetEnded() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  JoinedWorlds worlds_;

  absl::Mutex mutex_;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  // All that there are, and some that have ended: they are forgotten when there are many.
  std::vector<std::weak_ptr<DmEnvRpcReactor>> streams_ ABSL_GUARDED_BY(mutex_);
  size_t streams_kept_max_ ABSL_GUARDED_BY(mutex_) = kStreamsKeptMin;
};

}  // namespace procgen

#endif  // SERVER_RPC_DM_ENV_RPC_DM_ENV_RPC_SERVICE_H_
