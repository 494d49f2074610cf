#ifndef SERVER_RPC_STEP_STEP_POOL_REACTOR_H_
#define SERVER_RPC_STEP_STEP_POOL_REACTOR_H_

#include <memory>

#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/step/step_stream.h"
#include "server/rpc/step/stream_transport.h"
#include "server/session/pool_supervisor.h"
#include "server/shared_memory/pipe_listener.h"

namespace procgen {

// The gRPC side of a stream of StepPool: carries messages for a StepStream, which decides all else.
// Deletes itself when gRPC has done with it.
class StepPoolReactor final : public ByteStream, public StreamTransport {
 public:
  // Begins to serve a stream; it ends itself. `pipe_listener`: null: no pipes are offered. What is
  // pointed to must outlive it.
  static StepPoolReactor* Start(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                PipeListener* pipe_listener, grpc::CallbackServerContext* context,
                                Caller caller);

 private:
  StepPoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting,
                  grpc::CallbackServerContext* context);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  bool Read() override;
  absl::Status Take(StreamRequest* request) override;
  void Write(Outgoing* outgoing) override;
  void End(const absl::Status& status);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  grpc::CallbackServerContext* const context_;
  // Shared, because a callback of the pool may still be on its way out when gRPC has done with the
  // stream.
  std::shared_ptr<StepStream> stream_;
  grpc::ByteBuffer read_bytes_;  // of the read under way, or the request that was read
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_STEP_POOL_REACTOR_H_
