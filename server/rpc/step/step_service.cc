#include "server/rpc/step/step_service.h"

#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/call/refused_stream.h"
#include "server/rpc/grpc/method_name.h"
#include "server/rpc/step/step_pool_reactor.h"

namespace procgen {

StepServiceImpl::StepServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                 PipeListener* pipe_listener)
    : supervisor_(supervisor), accounting_(accounting), pipe_listener_(pipe_listener) {
  AddByteMethod<v1::StepPoolRequest>([this](auto* context) { return StepPool(context); });
}

ByteStream* StepServiceImpl::StepPool(grpc::CallbackServerContext* context) {
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  if (!caller.ok()) {
    return new RefusedStream(
        accounting_->EndCall(MethodNameOf<v1::StepPoolRequest>(), caller.status()));
  }
  return StepPoolReactor::Start(supervisor_, accounting_, pipe_listener_, context,
                                *std::move(caller));
}

}  // namespace procgen
