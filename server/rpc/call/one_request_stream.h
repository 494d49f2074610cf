#ifndef SERVER_RPC_CALL_ONE_REQUEST_STREAM_H_
#define SERVER_RPC_CALL_ONE_REQUEST_STREAM_H_

#include <atomic>
#include <memory>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "grpcpp/alarm.h"
#include "grpcpp/support/byte_buffer.h"
#include "server/rpc/call/byte_service.h"

namespace procgen {

// A call of a method that takes one request. Threads: reactions run one at a time, the timeout
// beside them.
class OneRequestStream : public ByteStream {
 protected:
  ~OneRequestStream() override = default;

  // Reads the request; OnRequest follows once, on any thread. To be called once, before any other
  // operation of the stream, and not after Finish.
  void ReadRequest(absl::Duration timeout);

  // Receives the request. Errors: DEADLINE_EXCEEDED no request within the timeout; CANCELLED the
  // call ended before it arrived.
  virtual void OnRequest(absl::StatusOr<grpc::ByteBuffer> request) = 0;

 private:
  void OnReadDone(bool ok) final;

  grpc::ByteBuffer request_;
  // This until the request or the timeout has taken it. Shared with the alarm, whose callback may
  // run after this has gone.
  std::shared_ptr<std::atomic<OneRequestStream*>> waiting_;
  grpc::Alarm alarm_;
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_ONE_REQUEST_STREAM_H_
