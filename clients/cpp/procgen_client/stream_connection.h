#ifndef PROCGEN_CLIENT_STREAM_CONNECTION_H_
#define PROCGEN_CLIENT_STREAM_CONNECTION_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/async_stream.h"
#include "procgen/v1/step.grpc.pb.h"
#include "procgen_client/call_completions.h"
#include "procgen_client/cancellation.h"
#include "procgen_client/pipe_transport.h"

namespace procgen_client {

// One call of StepPool; a StepStream has one after the other.
// Threads: one may write while another reads; TryCancel of the context from any.
class StreamConnection : public std::enable_shared_from_this<StreamConnection> {
 public:
  // `cancellation`: of the whole stream. `waits_for_server`: whether the call goes on while the
  // server cannot be reached.
  StreamConnection(std::shared_ptr<Cancellation> cancellation, const std::string& token,
                   bool waits_for_server);
  // Cancels the call, unless it has ended.
  ~StreamConnection();
  StreamConnection(const StreamConnection&) = delete;
  StreamConnection& operator=(const StreamConnection&) = delete;

  // The context of the call, which it keeps alive.
  std::shared_ptr<grpc::ClientContext> context() { return {shared_from_this(), &context_}; }
  // Begins the call and sends its first request. False: it has ended.
  bool Start(procgen::v1::StepService::Stub* stub, const procgen::v1::StepPoolRequest& attach);
  // Has pipes bear the messages from now on, where they can be had.
  void OpenPipes(const procgen::v1::Attached& attached);

  // False: it has ended.
  bool Write(const procgen::v1::StepPoolRequest& request);
  bool Read(procgen::v1::StepPoolResponse* response);
  // Reads the next response that may be the answer to request `number`; false: it has ended.
  // Errors: DATA_LOSS what came is no response, or too many that answer nothing.
  absl::StatusOr<bool> ReadAnswer(int64_t number, procgen::v1::StepPoolResponse* response);
  // Sends nothing more: the server ends the call.
  void EndRequests();
  // Waits until the server has ended the call and returns how. Errors: as AwaitEnd of call_end.h.
  absl::Status AwaitEnd(grpc::Status* end);

 private:
  bool ReadFromCall(procgen::v1::StepPoolResponse* response);

  const std::shared_ptr<Cancellation> cancellation_;
  grpc::ClientContext context_;
  CallCompletions completions_;
  std::unique_ptr<
      grpc::ClientAsyncReaderWriter<procgen::v1::StepPoolRequest, procgen::v1::StepPoolResponse>>
      stream_;
  // Bears the messages after attach; null: the stream does.
  std::unique_ptr<PipeTransport> pipes_;
  std::optional<grpc::Status> end_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_STREAM_CONNECTION_H_
