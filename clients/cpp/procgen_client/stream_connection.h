#ifndef PROCGEN_CLIENT_STREAM_CONNECTION_H_
#define PROCGEN_CLIENT_STREAM_CONNECTION_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "procgen/v1/step.grpc.pb.h"
#include "procgen_client/pipe_transport.h"

namespace procgen_client {

// One StepPool call. A StepStream opens a new one for each connection.
struct StreamConnection {
  grpc::ClientContext context;
  std::unique_ptr<
      grpc::ClientReaderWriter<procgen::v1::StepPoolRequest, procgen::v1::StepPoolResponse>>
      stream;
  // Carries the messages after attach; null: the gRPC stream does.
  std::unique_ptr<PipeTransport> pipes;

  // Both return false if the stream has ended.
  bool Write(const procgen::v1::StepPoolRequest& request) const;
  bool Read(procgen::v1::StepPoolResponse* response) const;
  // Reads the next response, skipping those of unknown kinds that answer no request. False: the
  // stream has ended. Errors: DATA_LOSS a malformed response, or too many of unknown kinds;
  // `number` is the request for the message.
  absl::StatusOr<bool> ReadAnswer(int64_t number, procgen::v1::StepPoolResponse* response) const;
};

// The context of a connection; the pointer keeps the connection alive.
std::shared_ptr<grpc::ClientContext> ContextOf(const std::shared_ptr<StreamConnection>& connection);

// As AwaitEnd in call_end.h, for a connection.
absl::Status AwaitEnd(const std::shared_ptr<StreamConnection>& connection, grpc::Status* end);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_STREAM_CONNECTION_H_
