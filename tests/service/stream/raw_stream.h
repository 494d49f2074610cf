#ifndef TESTS_SERVICE_STREAM_RAW_STREAM_H_
#define TESTS_SERVICE_STREAM_RAW_STREAM_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "gtest/gtest.h"
#include "procgen/v1/step.grpc.pb.h"

namespace procgen {

// A StepPool stream of the generated stub, message by message.
class RawStream {
 public:
  RawStream(v1::StepService::Stub* stub, const v1::Attach& attach)
      : stream_(stub->StepPool(&context_)) {
    v1::StepPoolRequest request;
    *request.mutable_attach() = attach;
    stream_->Write(request);
  }
  ~RawStream() {
    if (!finished_) {
      context_.TryCancel();
      stream_->Finish();
    }
  }
  RawStream(const RawStream&) = delete;
  RawStream& operator=(const RawStream&) = delete;

  void Send(v1::StepPoolRequest request, int64_t number, int64_t acknowledged = 0) {
    request.set_sequence_number(number);
    request.set_acknowledged_sequence_number(acknowledged);
    stream_->Write(request);
  }
  v1::StepPoolResponse Receive() {
    v1::StepPoolResponse response;
    EXPECT_TRUE(stream_->Read(&response));
    return response;
  }
  absl::Status Finish() {
    v1::StepPoolResponse response;
    while (stream_->Read(&response)) {
    }
    finished_ = true;
    const grpc::Status status = stream_->Finish();
    return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
  }
  void HalfClose() { stream_->WritesDone(); }
  // Cancels the stream, as a lost connection does.
  void Break() {
    context_.TryCancel();
    Finish().IgnoreError();
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StepPoolRequest, v1::StepPoolResponse>> stream_;
  bool finished_ = false;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_STREAM_RAW_STREAM_H_
