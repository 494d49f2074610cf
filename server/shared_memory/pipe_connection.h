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

// The server's side of two pipes that carry a stream's messages past gRPC: requests and responses,
// each preceded by its length as a uint32 in native byte order (both ends are on one machine).
//
// Threads can poll for messages (Receive); only if none is there must a thread be woken (Watch,
// AwaitInput).
// Threads: one may receive while another sends and a third one waits; Watch and HangUp from any
// thread.
class PipeConnection {
 public:
  // `message_bytes_max`: of received messages. Returns null if the process or system has no file
  // descriptors left.
  static std::unique_ptr<PipeConnection> Make(size_t message_bytes_max);
  ~PipeConnection();
  PipeConnection(const PipeConnection&) = delete;
  PipeConnection& operator=(const PipeConnection&) = delete;

  // Sends the learner its ends of the pipes, once, over a connected unix socket: a byte 0 with the
  // write end for requests and the read end for responses. Returns false if the learner is gone.
  bool HandOver(int socket);

  // Returns the next message, valid until the next call; nullopt: none yet. Errors: CANCELLED the
  // pipes have ended; RESOURCE_EXHAUSTED the message is too large, and the pipes are unusable.
  absl::StatusOr<std::optional<absl::string_view>> Receive();

  // Makes AwaitInput return, once, when there is unreceived input or the pipes have ended.
  void Watch();
  // Waits for the event of Watch. Returns false if this side has hung up.
  bool AwaitInput();

  // Sends a message, given in pieces, without blocking. Returns false if the pipes have ended or
  // the peer does not read.
  bool Send(const std::vector<absl::string_view>& pieces);

  // Ends the pipes for both sides. The peer can still receive what was sent.
  void HangUp();

 private:
  enum class Filled : uint8_t { kYes, kNotYet, kEnded };

  explicit PipeConnection(size_t message_bytes_max);
  bool MakePipes();
  bool WatchPipes();
  // Whether `count` bytes from begin_ on have been received.
  Filled Fill(size_t count);

  const size_t message_bytes_max_;
  FileDescriptor requests_;
  FileDescriptor responses_;
  // The read end of the responses, never read here. While it is open, writing raises no SIGPIPE. It
  // also notifies the waiting thread that this side hung up.
  FileDescriptor responses_read_;
  FileDescriptor learners_requests_;  // until they are handed over
  FileDescriptor learners_responses_;
  FileDescriptor watch_;  // an epoll of the read ends
  std::atomic<bool> hung_up_ = false;
  std::vector<char> buffer_;  // received: [begin_, end_)
  size_t begin_ = 0;
  size_t end_ = 0;
  std::string outgoing_;  // length and message; memory is reused
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_PIPE_CONNECTION_H_
