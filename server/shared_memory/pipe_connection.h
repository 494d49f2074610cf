#ifndef SERVER_SHARED_MEMORY_PIPE_CONNECTION_H_
#define SERVER_SHARED_MEMORY_PIPE_CONNECTION_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/shared_memory/file_descriptor.h"

namespace procgen {

// The server's side of two pipes by which a learner and its stream exchange messages past gRPC:
// requests and responses, each after its length as an unsigned number of four bytes (both are on
// one machine, so in its order).
//
// Nobody has to wait for messages: who has time polls for the next one (Receive), and only who
// finds none has a thread woken by it (Watch, AwaitInput). Threads: one may receive while another
// sends and a third one waits; Watch and HangUp from any.
class PipeConnection {
 public:
  // Messages that are received have at most `message_bytes_max`. Null: the process or the system
  // has no file descriptors left for it.
  static std::unique_ptr<PipeConnection> Make(size_t message_bytes_max);
  ~PipeConnection();
  PipeConnection(const PipeConnection&) = delete;
  PipeConnection& operator=(const PipeConnection&) = delete;

  // Gives the learner its ends of the pipes, once, through a connected unix socket: a byte 0 with
  // the end to write requests to and the end to read responses from. False: it is not there.
  bool HandOver(int socket);

  // The next message, good until the next call; none: it is not there yet. Errors: CANCELLED the
  // pipes have ended; RESOURCE_EXHAUSTED the message is larger, and the pipes of no more use.
  absl::StatusOr<std::optional<absl::string_view>> Receive();

  // Has AwaitInput return, once, when there are bytes that were not received or the pipes have
  // ended.
  void Watch();
  // Waits for what Watch asks for. False: this side has hung up, and it would wait for nothing.
  bool AwaitInput();

  // Sends a message that is given in pieces, without waiting. False: the pipes have ended, or
  // whoever is there reads nothing.
  bool Send(const std::vector<absl::string_view>& pieces);

  // Ends the pipes for both sides: what was sent can still be received there.
  void HangUp();

 private:
  enum class Filled : uint8_t { kYes, kNotYet, kEnded };

  explicit PipeConnection(size_t message_bytes_max);
  bool MakePipes();
  bool WatchPipes();
  // Whether `count` bytes are there from begin_ on.
  Filled Fill(size_t count);

  const size_t message_bytes_max_;
  FileDescriptor requests_;
  FileDescriptor responses_;
  // Their reading end, from which nobody reads here: while it is open, nobody who writes gets a
  // SIGPIPE; and it tells who waits that this side hung up.
  FileDescriptor responses_read_;
  FileDescriptor learners_requests_;  // until they are handed over
  FileDescriptor learners_responses_;
  FileDescriptor watch_;  // an epoll that knows what is read here
  std::atomic<bool> hung_up_ = false;
  std::vector<char> buffer_;  // received: [begin_, end_)
  size_t begin_ = 0;
  size_t end_ = 0;
  std::string outgoing_;  // length and message; its memory is kept
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_PIPE_CONNECTION_H_
