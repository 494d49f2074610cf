#ifndef SERVER_RPC_STEP_SERVICE_H_
#define SERVER_RPC_STEP_SERVICE_H_

#include "procgen/v1/step.grpc.pb.h"
#include "server/session/sessions.h"

namespace procgen {

// StepService: each stream is a StepPoolReactor.
class StepServiceImpl final
    : public v1::StepService::WithRawCallbackMethod_StepPool<v1::StepService::Service> {
 public:
  // `sessions` must outlive this.
  explicit StepServiceImpl(Sessions* sessions) : sessions_(sessions) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StepPool(
      grpc::CallbackServerContext* context) override;

 private:
  Sessions* const sessions_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_SERVICE_H_
