#ifndef PROCGEN_CLIENT_INTERNAL_PIPE_TRANSPORT_H_
#define PROCGEN_CLIENT_INTERNAL_PIPE_TRANSPORT_H_

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "procgen/v1/step.pb.h"
#include "procgen_client/cancellation.h"

namespace procgen_client {

// The client side of procgen.v1.PipeTransport: two pipes that carry the messages of a stream in
// place of gRPC.
// Threads: one may send while another receives; HangUp and Interrupt from any.
class PipeTransport {
 public:
  // Opens the pipes; null if that fails, and the caller keeps using the gRPC stream.
  // `response_bytes_max`: largest response that is accepted. `cancellation`: of the stream; ends
  // waits.
  static std::unique_ptr<PipeTransport> Open(const procgen::v1::PipeTransport& offer,
                                             int64_t response_bytes_max,
                                             std::shared_ptr<Cancellation> cancellation);
  ~PipeTransport();
  PipeTransport(const PipeTransport&) = delete;
  PipeTransport& operator=(const PipeTransport&) = delete;

  // Blocks while the pipe is full. False: the pipe has ended and gRPC's stream has the status, or
  // the wait was cancelled.
  bool Send(const procgen::v1::StepPoolRequest& request);
  // Blocks until the next response. False: as Send, or is_damaged().
  bool Receive(procgen::v1::StepPoolResponse* response);
  // Whether Receive returned false because of a malformed response.
  bool is_damaged() const { return is_damaged_; }
  // Closes the request pipe: the stream ends when all requests sent are answered.
  void HangUp() const;
  // Ends a blocked Receive after a cancellation that its thread cannot notice by itself.
  void Interrupt() const;

 private:
  PipeTransport(int64_t response_bytes_max, std::shared_ptr<Cancellation> cancellation)
      : response_bytes_max_(response_bytes_max), cancellation_(std::move(cancellation)) {}
  // Receives the file descriptors of the pipes.
  bool TakeEnds(int socket);
  // Blocks until the request pipe is writable. False: the pipes have ended, or cancelled.
  bool AwaitRoom() const;
  // Blocks until the response pipe is readable or has ended. False: cancelled. Only for streams
  // with a cancellation check; without one, reads block, which saves two system calls a response.
  bool AwaitResponse() const;
  // Blocks until buffer_ has `count` bytes from begin_ on. False: the pipe has ended.
  bool Fill(size_t count);

  const int64_t response_bytes_max_;
  const std::shared_ptr<Cancellation> cancellation_;
  bool is_damaged_ = false;
  int requests_ = -1;
  // Read end of the request pipe, never read: while it is open, writing raises no SIGPIPE.
  int requests_read_ = -1;
  int responses_ = -1;
  std::string outgoing_;      // length and message; reused for each request
  std::vector<char> buffer_;  // received: [begin_, end_)
  size_t begin_ = 0;
  size_t end_ = 0;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_PIPE_TRANSPORT_H_
