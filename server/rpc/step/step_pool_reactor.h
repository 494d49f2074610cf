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

// The gRPC reactor of a StepPool stream: the transport of a StepStream, which makes all decisions.
// Deletes itself in OnDone.
class StepPoolReactor final : public ByteStream, public StreamTransport {
 public:
  // Starts to serve a stream. `pipe_listener`: null: pipes are not offered. All pointers must
  // outlive the reactor.
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
  absl::Status Parse(StreamRequest* request) override;
  void Write(Outgoing* outgoing) override;
  void End(const absl::Status& status);

  PoolSupervisor* const supervisor_;
  const CallAccounting* const accounting_;
  grpc::CallbackServerContext* const context_;
  // Shared, because a callback of the pool may still be returning when gRPC calls OnDone.
  std::shared_ptr<StepStream> stream_;
  grpc::ByteBuffer read_bytes_;  // of the current read, until Parse
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_STEP_POOL_REACTOR_H_
