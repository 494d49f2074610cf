#ifndef SERVER_SHARED_MEMORY_DIRECT_LINE_H_
#define SERVER_SHARED_MEMORY_DIRECT_LINE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen {

// One side of a unix socket on which a learner and its stream exchange messages past gRPC, each
// after its length as an unsigned number of four bytes (both are on one machine, so in its order).
// Threads: one may receive while another sends; HangUp from any.
class DirectLine {
 public:
  // Takes over a connected socket. Messages that are received have at most `message_bytes_max`.
  DirectLine(int descriptor, size_t message_bytes_max);
  ~DirectLine();
  DirectLine(const DirectLine&) = delete;
  DirectLine& operator=(const DirectLine&) = delete;

  // Waits for the next message, which is good until the next call. Errors: CANCELLED the line has
  // ended; RESOURCE_EXHAUSTED the message is larger, and the line of no more use.
  absl::StatusOr<absl::string_view> Receive();
  // Waits for so many bytes that are no message. Errors: CANCELLED.
  absl::StatusOr<absl::string_view> ReceiveBytes(size_t count);

  // Sends a message that is given in pieces, without waiting. False: the line has ended, or whoever
  // is there reads nothing.
  bool Send(const std::vector<absl::string_view>& pieces);

  // Ends the line for both sides: what was sent can still be received there.
  void HangUp();

  int descriptor() const { return descriptor_; }

 private:
  // Waits until `count` bytes are there from begin_ on.
  bool Fill(size_t count);

  const int descriptor_;
  const size_t message_bytes_max_;
  std::vector<char> buffer_;  // received: [begin_, end_)
  size_t begin_ = 0;
  size_t end_ = 0;
  std::string outgoing_;  // length and message; its memory is kept
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_DIRECT_LINE_H_
