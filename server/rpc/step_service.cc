#include "server/rpc/step_service.h"

#include "server/rpc/step_pool_reactor.h"

namespace procgen {

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StepServiceImpl::StepPool(
    grpc::CallbackServerContext* context) {
  return StepPoolReactor::Start(sessions_, context);
}

}  // namespace procgen
