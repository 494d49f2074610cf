#ifndef SERVER_RPC_STATE_SERVICE_H_
#define SERVER_RPC_STATE_SERVICE_H_

#include "procgen/v1/states.grpc.pb.h"
#include "server/session/sessions.h"

namespace procgen {

// StateService: saves, restores and clones environments, each in a turn at their pool and on the
// side crew. A call has one turn at a time, so calls between the same pools cannot wait for one
// another. Serves while the server drains, too.
class StateServiceImpl final
    : public v1::StateService::WithRawCallbackMethod_SaveStates<
          v1::StateService::WithRawCallbackMethod_RestoreStates<
              v1::StateService::WithRawCallbackMethod_CloneStates<v1::StateService::Service>>> {
 public:
  // `sessions` must outlive this.
  explicit StateServiceImpl(Sessions* sessions) : sessions_(sessions) {}

  grpc::ServerUnaryReactor* SaveStates(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* RestoreStates(grpc::CallbackServerContext* context,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* CloneStates(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;

 private:
  Sessions* const sessions_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STATE_SERVICE_H_
