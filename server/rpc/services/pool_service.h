#ifndef SERVER_RPC_SERVICES_POOL_SERVICE_H_
#define SERVER_RPC_SERVICES_POOL_SERVICE_H_

#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "procgen/v1/pool_service.grpc.pb.h"
#include "server/pool/pool_supervisor.h"
#include "server/pool/watch/frame_publishers.h"
#include "server/rpc/auth/call_accounting.h"

namespace procgen {

// The base of PoolServiceImpl. Pictures are sent from the memory that they are drawn into, so the
// streams handle serialised messages.
using PoolServiceBase =
    v1::PoolService::WithRawCallbackMethod_RunPool<v1::PoolService::WithRawCallbackMethod_WatchPool<
        v1::PoolService::WithCallbackMethod_GetPool<v1::PoolService::WithCallbackMethod_ListPools<
            v1::PoolService::WithCallbackMethod_GetEpisode<
                v1::PoolService::WithCallbackMethod_ListEpisodes<
                    v1::PoolService::WithCallbackMethod_GetPoolHistory<
                        v1::PoolService::WithCallbackMethod_PausePool<
                            v1::PoolService::Service>>>>>>>>;

// PoolService: each stream of RunPool is a RunPoolReactor; the others look at the pools.
class PoolServiceImpl final : public PoolServiceBase {
 public:
  // The pointers must outlive this.
  PoolServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting)
      : supervisor_(supervisor), accounting_(accounting) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* RunPool(
      grpc::CallbackServerContext* context) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchPool(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request) override;
  grpc::ServerUnaryReactor* GetPool(grpc::CallbackServerContext* context,
                                    const v1::GetPoolRequest* request, v1::Pool* response) override;
  grpc::ServerUnaryReactor* ListPools(grpc::CallbackServerContext* context,
                                      const v1::ListPoolsRequest* request,
                                      v1::ListPoolsResponse* response) override;
  grpc::ServerUnaryReactor* GetEpisode(grpc::CallbackServerContext* context,
                                       const v1::GetEpisodeRequest* request,
                                       v1::Episode* response) override;
  grpc::ServerUnaryReactor* ListEpisodes(grpc::CallbackServerContext* context,
                                         const v1::ListEpisodesRequest* request,
                                         v1::ListEpisodesResponse* response) override;
  grpc::ServerUnaryReactor* GetPoolHistory(grpc::CallbackServerContext* context,
                                           const v1::GetPoolHistoryRequest* request,
                                           v1::PoolHistory* response) override;
  grpc::ServerBidiReactor<v1::PausePoolRequest, v1::PausePoolResponse>* PausePool(
      grpc::CallbackServerContext* context) override;

 private:
  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  FramePublishers publishers_;  // for WatchPool
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_POOL_SERVICE_H_
