#ifndef PROCGEN_CLIENT_INTERNAL_STREAM_CONNECTION_H_
#define PROCGEN_CLIENT_INTERNAL_STREAM_CONNECTION_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/async_stream.h"
#include "procgen/v1/step.grpc.pb.h"
#include "procgen_client/cancellation.h"
#include "procgen_client/internal/call_completions.h"
#include "procgen_client/internal/pipe_transport.h"

namespace procgen_client {

// One StepPool call. A StepStream opens a new one for each connection.
// Threads: one may write while another reads; TryCancel of the context from any.
class StreamConnection : public std::enable_shared_from_this<StreamConnection> {
 public:
  // `cancellation`: of the whole stream. `waits_for_server`: whether the call waits while the
  // server cannot be reached.
  StreamConnection(std::shared_ptr<Cancellation> cancellation, const std::string& token,
                   bool waits_for_server);
  // Cancels the call, unless it has ended.
  ~StreamConnection();
  StreamConnection(const StreamConnection&) = delete;
  StreamConnection& operator=(const StreamConnection&) = delete;

  // The context of the call; the pointer keeps the connection alive.
  std::shared_ptr<grpc::ClientContext> context() { return {shared_from_this(), &context_}; }
  // Starts the call and sends its first request. False: the call has ended.
  bool Start(procgen::v1::StepService::Stub* stub, const procgen::v1::StepPoolRequest& attach);
  // Uses pipes for all further messages if the server offers them and they open.
  void OpenPipes(const procgen::v1::Attached& attached);

  // Cancels the call and ends its waits, after a cancellation. From any thread.
  void Interrupt();

  // Both return false if the call has ended.
  bool Write(const procgen::v1::StepPoolRequest& request);
  bool Read(procgen::v1::StepPoolResponse* response);
  // Reads the next response, skipping those of unknown kinds that answer no request. False: the
  // call has ended. Errors: DATA_LOSS a malformed response, or too many of unknown kinds; `number`
  // is the request for the message.
  absl::StatusOr<bool> ReadAnswer(int64_t number, procgen::v1::StepPoolResponse* response);
  // Half-closes: no requests follow, and the server ends the call.
  void EndRequests();
  // Waits for the end of the call after EndRequests; `end` is its status. Errors: DEADLINE_EXCEEDED
  // the server does not end it within 10 s; it is cancelled then.
  absl::Status AwaitEnd(grpc::Status* end);
  // The same after a failed read or write. Errors: as AwaitEnd in call_end.h.
  absl::Status AwaitEndAfterFailure(grpc::Status* end);

 private:
  bool ReadFromCall(procgen::v1::StepPoolResponse* response);
  // Drops the remaining responses and stores the status of the call.
  void ReadEnd(grpc::Status* end);

  const std::shared_ptr<Cancellation> cancellation_;
  grpc::ClientContext context_;
  CallCompletions completions_;
  std::unique_ptr<
      grpc::ClientAsyncReaderWriter<procgen::v1::StepPoolRequest, procgen::v1::StepPoolResponse>>
      stream_;
  // Carries the messages after attach; null: the gRPC stream does.
  std::unique_ptr<PipeTransport> pipes_;
  std::optional<grpc::Status> end_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_STREAM_CONNECTION_H_
