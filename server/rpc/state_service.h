#ifndef SERVER_RPC_STATE_SERVICE_H_
#define SERVER_RPC_STATE_SERVICE_H_

#include "procgen/v1/states.grpc.pb.h"

namespace procgen {

// StateService: snapshots are not offered yet, and every call says so.
class StateServiceImpl final
    : public v1::StateService::WithRawCallbackMethod_SaveStates<
          v1::StateService::WithRawCallbackMethod_RestoreStates<
              v1::StateService::WithRawCallbackMethod_CloneStates<v1::StateService::Service>>> {
 public:
  grpc::ServerUnaryReactor* SaveStates(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* RestoreStates(grpc::CallbackServerContext* context,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* CloneStates(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
};

}  // namespace procgen

#endif  // SERVER_RPC_STATE_SERVICE_H_
