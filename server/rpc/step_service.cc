#include "server/rpc/step_service.h"

#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/method_name.h"
#include "server/rpc/refused_stream.h"
#include "server/rpc/step_pool_reactor.h"

namespace procgen {

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StepServiceImpl::StepPool(
    grpc::CallbackServerContext* context) {
  absl::StatusOr<Caller> caller = callers_->Admit(*context);
  if (!caller.ok()) {
    using Stream = grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>;
    return new RefusedStream<Stream>(
        callers_->Dismiss(MethodNameOf<v1::StepPoolRequest>(), caller.status()));
  }
  return StepPoolReactor::Start(sessions_, callers_, direct_lines_, context, *std::move(caller));
}

}  // namespace procgen
