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

// A call of a method that takes one request.
// Threads: gRPC's reactions run one at a time; the timeout may run concurrently.
class OneRequestStream : public ByteStream {
 protected:
  ~OneRequestStream() override = default;

  // Reads the request, then calls OnRequest once, on any thread. Must be called once, before any
  // other operation of the stream.
  void ReadRequest(absl::Duration timeout);

  // Receives the request. Errors: DEADLINE_EXCEEDED no request within the timeout; CANCELLED the
  // call ended before it arrived.
  virtual void OnRequest(absl::StatusOr<grpc::ByteBuffer> request) = 0;

 private:
  void OnReadDone(bool ok) final;

  grpc::ByteBuffer request_;
  // This object, until OnReadDone or the timeout takes it. Shared with the alarm, whose callback
  // may run after the object is deleted.
  std::shared_ptr<std::atomic<OneRequestStream*>> waiting_;
  grpc::Alarm alarm_;
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_ONE_REQUEST_STREAM_H_
