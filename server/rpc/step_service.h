#ifndef SERVER_RPC_STEP_SERVICE_H_
#define SERVER_RPC_STEP_SERVICE_H_

#include "procgen/v1/step.grpc.pb.h"
#include "server/rpc/caller.h"
#include "server/session/sessions.h"

namespace procgen {

// StepService: each stream is a StepPoolReactor.
class StepServiceImpl final
    : public v1::StepService::WithRawCallbackMethod_StepPool<v1::StepService::Service> {
 public:
  // `sessions` and `callers` must outlive this.
  StepServiceImpl(Sessions* sessions, const Callers* callers)
      : sessions_(sessions), callers_(callers) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StepPool(
      grpc::CallbackServerContext* context) override;

 private:
  Sessions* const sessions_;
  const Callers* const callers_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_SERVICE_H_
