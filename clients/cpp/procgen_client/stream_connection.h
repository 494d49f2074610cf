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

// One call of StepPool; a StepStream has one after the other.
struct StreamConnection {
  grpc::ClientContext context;
  std::unique_ptr<
      grpc::ClientReaderWriter<procgen::v1::StepPoolRequest, procgen::v1::StepPoolResponse>>
      stream;
  // Bears the messages after attach; null: the stream does.
  std::unique_ptr<PipeTransport> pipes;

  // False: it has ended.
  bool Write(const procgen::v1::StepPoolRequest& request) const;
  bool Read(procgen::v1::StepPoolResponse* response) const;
  // Reads the next response that may be the answer to request `number`; false: it has ended.
  // Errors: DATA_LOSS what came is no response, or too many that answer nothing.
  absl::StatusOr<bool> ReadAnswer(int64_t number, procgen::v1::StepPoolResponse* response) const;
};

// The context of a connection, which it keeps alive.
std::shared_ptr<grpc::ClientContext> ContextOf(const std::shared_ptr<StreamConnection>& connection);

// AwaitEnd of call_end.h for a connection.
absl::Status AwaitEnd(const std::shared_ptr<StreamConnection>& connection, grpc::Status* end);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_STREAM_CONNECTION_H_
