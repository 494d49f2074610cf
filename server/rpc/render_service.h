#ifndef SERVER_RPC_RENDER_SERVICE_H_
#define SERVER_RPC_RENDER_SERVICE_H_

#include "absl/status/statusor.h"
#include "procgen/v1/render.grpc.pb.h"
#include "server/rpc/caller.h"
#include "server/rpc/watch_pool_reactor.h"
#include "server/session/sessions.h"

namespace procgen {

// RenderService: draws environments for people.
class RenderServiceImpl final
    : public v1::RenderService::WithRawCallbackMethod_RenderEnvironments<
          v1::RenderService::WithRawCallbackMethod_WatchPool<v1::RenderService::Service>> {
 public:
  // `sessions` and `callers` must outlive this.
  RenderServiceImpl(Sessions* sessions, const Callers* callers)
      : sessions_(sessions), callers_(callers) {}

  grpc::ServerUnaryReactor* RenderEnvironments(grpc::CallbackServerContext* context,
                                               const grpc::ByteBuffer* request,
                                               grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchPool(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request) override;

 private:
  absl::StatusOr<WatchPoolReactor*> StartWatch(const grpc::CallbackServerContext& context,
                                               const grpc::ByteBuffer& request);

  Sessions* const sessions_;
  const Callers* const callers_;
};

}  // namespace procgen

#endif  // SERVER_RPC_RENDER_SERVICE_H_
