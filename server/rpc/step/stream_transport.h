#ifndef SERVER_RPC_STEP_STREAM_TRANSPORT_H_
#define SERVER_RPC_STEP_STREAM_TRANSPORT_H_

#include "absl/status/status.h"
#include "server/rpc/step/response_queue.h"
#include "server/wire/convert_step.h"

namespace procgen {

class StreamTransport;

// What a transport reports to. Threads: any, also within a call of the transport.
class StreamTransportUser {
 public:
  virtual ~StreamTransportUser() = default;
  // A read has ended. OK: a request has arrived, to be fetched by Take. Errors: CANCELLED no other
  // request comes; RESOURCE_EXHAUSTED it is too large, and no other can be read.
  virtual void OnRead(StreamTransport* transport, const absl::Status& status) = 0;
  // A write has ended. Not `ok`: the learner is not there any more.
  virtual void OnWritten(bool ok) = 0;
};

// Carries the messages of one stream of StepPool: the gRPC stream itself, or pipes beside shared
// memory. At most one read and one write are under way.
class StreamTransport {
 public:
  virtual ~StreamTransport() = default;

  // Begins to read a request, which ends with OnRead, maybe before this returns. False: none has
  // arrived, and the read goes on with Await.
  virtual bool Read() = 0;
  // Waits for the request of such a read: called when the stream has nothing else to do.
  virtual void Await() {}
  // Parses the request that was read, and fills in its size. Errors: INVALID_ARGUMENT.
  virtual absl::Status Take(StreamRequest* request) = 0;
  // Begins to send a response, which ends with OnWritten, maybe before this returns. `outgoing`
  // must stay valid until then.
  virtual void Write(Outgoing* outgoing) = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_STREAM_TRANSPORT_H_
