#ifndef SERVER_SHARED_MEMORY_DIRECT_LINE_H_
#define SERVER_SHARED_MEMORY_DIRECT_LINE_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen {

// One side of a unix socket on which a learner and its stream exchange messages past gRPC, each
// after its length as an unsigned number of four bytes (both are on one machine, so in its order).
//
// Nobody has to wait for messages: who has time looks for the next one (Receive), and only who
// finds none has a thread woken by it (Watch, AwaitInput). Threads: one may receive while another
// sends and a third one waits; Watch and HangUp from any.
class DirectLine {
 public:
  // Takes over a connected socket. Messages that are received have at most `message_bytes_max`.
  // Null: the process has no file descriptor left to wait with.
  static std::unique_ptr<DirectLine> Take(int descriptor, size_t message_bytes_max);
  ~DirectLine();
  DirectLine(const DirectLine&) = delete;
  DirectLine& operator=(const DirectLine&) = delete;

  // Waits for so many bytes that are no message, good until the next call. Errors: CANCELLED the
  // line has ended.
  absl::StatusOr<absl::string_view> ReceiveBytes(size_t count);
  // The next message, good until the next call; none: it is not there yet. Errors: CANCELLED the
  // line has ended; RESOURCE_EXHAUSTED the message is larger, and the line of no more use.
  absl::StatusOr<std::optional<absl::string_view>> Receive();

  // Has AwaitInput return, once, when there are bytes that were not received or the line has ended.
  void Watch();
  // Waits for what Watch asks for. False: this side has hung up, and it would wait for nothing.
  bool AwaitInput();

  // Sends a message that is given in pieces, without waiting. False: the line has ended, or whoever
  // is there reads nothing.
  bool Send(const std::vector<absl::string_view>& pieces);

  // Ends the line for both sides: what was sent can still be received there.
  void HangUp();

  int descriptor() const { return descriptor_; }

 private:
  enum class Filled : uint8_t { kYes, kNotYet, kEnded };

  DirectLine(int descriptor, int watch, size_t message_bytes_max);
  // Whether `count` bytes are there from begin_ on, or come while it `waits`.
  Filled Fill(size_t count, bool waits);

  const int descriptor_;
  const int watch_;  // an epoll that knows the socket only
  const size_t message_bytes_max_;
  std::atomic<bool> hung_up_ = false;
  std::vector<char> buffer_;  // received: [begin_, end_)
  size_t begin_ = 0;
  size_t end_ = 0;
  std::string outgoing_;  // length and message; its memory is kept
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_DIRECT_LINE_H_
