#ifndef SERVER_RPC_STEP_STREAM_TRANSPORT_H_
#define SERVER_RPC_STEP_STREAM_TRANSPORT_H_

#include "absl/status/status.h"
#include "server/rpc/step/response_queue.h"
#include "server/wire/convert_step.h"

namespace procgen {

class StreamTransport;

// Receives the events of a transport. Threads: any, also within a call to the transport.
class StreamTransportUser {
 public:
  virtual ~StreamTransportUser() = default;
  // A read has ended. OK: a request has arrived; Parse returns it. Errors: CANCELLED no further
  // request comes; RESOURCE_EXHAUSTED the request is too large, and no further one can be read.
  virtual void OnRead(StreamTransport* transport, const absl::Status& status) = 0;
  // A write has ended. Not `ok`: the learner has disconnected.
  virtual void OnWritten(bool ok) = 0;
};

// Transports the messages of one StepPool stream: by the gRPC stream, or by pipes for pools with
// shared memory. At most one read and one write are in progress.
class StreamTransport {
 public:
  virtual ~StreamTransport() = default;

  // Starts a read, which ends with OnRead, maybe before this returns. False: no request has
  // arrived, and Await must continue the read.
  virtual bool Read() = 0;
  // Continues a read that returned false. Called when the stream has nothing else to do.
  virtual void Await() {}
  // Parses the received request and sets its size. Errors: INVALID_ARGUMENT.
  virtual absl::Status Parse(StreamRequest* request) = 0;
  // Starts to send a response, which ends with OnWritten, maybe before this returns. `outgoing`
  // must stay valid until then.
  virtual void Write(Outgoing* outgoing) = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_STREAM_TRANSPORT_H_
