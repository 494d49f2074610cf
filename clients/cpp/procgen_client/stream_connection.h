#ifndef PROCGEN_CLIENT_STREAM_CONNECTION_H_
#define PROCGEN_CLIENT_STREAM_CONNECTION_H_

#include <atomic>
#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "grpcpp/alarm.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "procgen/v1/step.grpc.pb.h"
#include "procgen_client/direct_line.h"

namespace procgen_client {

// One call of StepPool; a StepStream has one after the other.
struct StreamConnection {
  grpc::ClientContext context;
  std::unique_ptr<
      grpc::ClientReaderWriter<procgen::v1::StepPoolRequest, procgen::v1::StepPoolResponse>>
      stream;
  // Bears the messages after attach; null: the stream does.
  std::unique_ptr<DirectLine> line;

  // False: it has ended.
  bool Write(const procgen::v1::StepPoolRequest& request) const;
  bool Read(procgen::v1::StepPoolResponse* response) const;
  // Reads the next response that may be the answer to request `number`; false: it has ended.
  // Errors: DATA_LOSS what came is no response, or too many that answer nothing.
  absl::StatusOr<bool> ReadAnswer(int64_t number, procgen::v1::StepPoolResponse* response) const;
};

// Cancels a call when time is up, until this ends. Machines whose clock is set change nothing.
class CallTimer {
 public:
  CallTimer(const std::shared_ptr<StreamConnection>& connection, absl::Duration timeout);
  bool is_due() const { return *is_due_; }

 private:
  const std::shared_ptr<std::atomic<bool>> is_due_ = std::make_shared<std::atomic<bool>>(false);
  grpc::Alarm alarm_;
};

// Waits until the server has ended the call, and says how. Errors: DEADLINE_EXCEEDED it does not
// within 10 s; it is cancelled then.
absl::Status AwaitEnd(const std::shared_ptr<StreamConnection>& connection, grpc::Status* end);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_STREAM_CONNECTION_H_
