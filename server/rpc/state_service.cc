#include "server/rpc/state_service.h"

#include "server/rpc/unary_call.h"

namespace procgen {
namespace {

template <typename Request, typename Response>
grpc::ServerUnaryReactor* Refuse(const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  using Call = UnaryCall<Request, Response>;
  return Call::Start(request, response, [](Call* call) {
    call->Finish(absl::UnimplementedError("states are not offered yet"));
  });
}

}  // namespace

grpc::ServerUnaryReactor* StateServiceImpl::SaveStates(grpc::CallbackServerContext* /*context*/,
                                                       const grpc::ByteBuffer* request,
                                                       grpc::ByteBuffer* response) {
  return Refuse<v1::SaveStatesRequest, v1::SaveStatesResponse>(request, response);
}

grpc::ServerUnaryReactor* StateServiceImpl::RestoreStates(grpc::CallbackServerContext* /*context*/,
                                                          const grpc::ByteBuffer* request,
                                                          grpc::ByteBuffer* response) {
  return Refuse<v1::RestoreStatesRequest, v1::RestoreStatesResponse>(request, response);
}

grpc::ServerUnaryReactor* StateServiceImpl::CloneStates(grpc::CallbackServerContext* /*context*/,
                                                        const grpc::ByteBuffer* request,
                                                        grpc::ByteBuffer* response) {
  return Refuse<v1::CloneStatesRequest, v1::CloneStatesResponse>(request, response);
}

}  // namespace procgen
