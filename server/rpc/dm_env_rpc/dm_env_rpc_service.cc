#include "server/rpc/dm_env_rpc/dm_env_rpc_service.h"

#include <algorithm>
#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/call/refused_stream.h"
#include "server/rpc/grpc/method_name.h"

namespace procgen {

DmEnvRpcServiceImpl::DmEnvRpcServiceImpl(PoolSupervisor* supervisor,
                                         const CallAccounting* accounting)
    : supervisor_(supervisor), accounting_(accounting) {
  AddByteMethod<dm::EnvironmentRequest>([this](auto* context) { return Process(context); });
}

ByteStream* DmEnvRpcServiceImpl::Process(grpc::CallbackServerContext* context) {
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  if (!caller.ok()) {
    return new RefusedStream(
        accounting_->EndCall(MethodNameOf<dm::EnvironmentRequest>(), caller.status()));
  }
  const std::shared_ptr<DmEnvRpcReactor> stream =
      DmEnvRpcReactor::Start(supervisor_, &worlds_, accounting_, context, *std::move(caller));
  bool draining = false;
  {
    absl::MutexLock lock(&mutex_);
    draining = draining_;
    if (streams_.size() >= streams_kept_max_) {
      RemoveEnded();
    }
    streams_.push_back(stream);
  }
  if (draining) {
    stream->End(supervisor_->Draining());
  }
  return stream.get();
}

void DmEnvRpcServiceImpl::RemoveEnded() {
  streams_.erase(std::remove_if(streams_.begin(), streams_.end(),
                                [](const auto& stream) { return stream.expired(); }),
                 streams_.end());
  streams_kept_max_ = std::max(kStreamsKeptMin, 2 * streams_.size());
}

void DmEnvRpcServiceImpl::Drain() {
  std::vector<std::weak_ptr<DmEnvRpcReactor>> streams;
  {
    absl::MutexLock lock(&mutex_);
    draining_ = true;
    streams = streams_;
  }
  for (const std::weak_ptr<DmEnvRpcReactor>& ended : streams) {
    if (const std::shared_ptr<DmEnvRpcReactor> stream = ended.lock(); stream != nullptr) {
      stream->End(supervisor_->Draining());
    }
  }
}

}  // namespace procgen
