#ifndef SERVER_RPC_POOL_SERVICE_H_
#define SERVER_RPC_POOL_SERVICE_H_

#include "procgen/v1/pools.grpc.pb.h"
#include "server/rpc/caller.h"
#include "server/session/sessions.h"

namespace procgen {

// PoolService: makes, finds and ends pools.
class PoolServiceImpl final : public v1::PoolService::WithRawCallbackMethod_CreatePool<
                                  v1::PoolService::WithRawCallbackMethod_GetPool<
                                      v1::PoolService::WithRawCallbackMethod_ListPools<
                                          v1::PoolService::WithRawCallbackMethod_DeletePool<
                                              v1::PoolService::WithRawCallbackMethod_RenewPool<
                                                  v1::PoolService::Service>>>>> {
 public:
  // `sessions` and `callers` must outlive this.
  PoolServiceImpl(Sessions* sessions, const Callers* callers)
      : sessions_(sessions), callers_(callers) {}

  grpc::ServerUnaryReactor* CreatePool(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetPool(grpc::CallbackServerContext* context,
                                    const grpc::ByteBuffer* request,
                                    grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListPools(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* DeletePool(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* RenewPool(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;

 private:
  Sessions* const sessions_;
  const Callers* const callers_;
};

}  // namespace procgen

#endif  // SERVER_RPC_POOL_SERVICE_H_
