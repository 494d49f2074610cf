#ifndef SERVER_RPC_STATE_SERVICE_H_
#define SERVER_RPC_STATE_SERVICE_H_

#include <utility>

#include "procgen/v1/states.grpc.pb.h"
#include "server/rpc/caller.h"
#include "server/rpc/clone_sources.h"
#include "server/session/sessions.h"

namespace procgen {

// StateService: saves, restores and clones environments, and reads their episodes, each in a turn
// at their pool and on the side crew. A call has one turn at a time, so calls between the same
// pools cannot wait for one another. Serves while the server drains, too.
class StateServiceImpl final : public v1::StateService::WithRawCallbackMethod_SaveStates<
                                   v1::StateService::WithRawCallbackMethod_RestoreStates<
                                       v1::StateService::WithRawCallbackMethod_CloneStates<
                                           v1::StateService::WithRawCallbackMethod_ReadEpisode<
                                               v1::StateService::Service>>>> {
 public:
  // `sessions` and `callers` must outlive this.
  // `clone_sources`: the servers that CloneStates may be asked to read from.
  StateServiceImpl(Sessions* sessions, const Callers* callers, CloneSources clone_sources)
      : sessions_(sessions), callers_(callers), clone_sources_(std::move(clone_sources)) {}

  grpc::ServerUnaryReactor* SaveStates(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* RestoreStates(grpc::CallbackServerContext* context,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* CloneStates(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ReadEpisode(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;

 private:
  Sessions* const sessions_;
  const Callers* const callers_;
  const CloneSources clone_sources_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STATE_SERVICE_H_
