#ifndef SERVER_RPC_POOL_SERVICE_H_
#define SERVER_RPC_POOL_SERVICE_H_

#include "procgen/v1/pools.grpc.pb.h"
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
  // `sessions` must outlive this.
  explicit PoolServiceImpl(Sessions* sessions) : sessions_(sessions) {}

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
};

}  // namespace procgen

#endif  // SERVER_RPC_POOL_SERVICE_H_
