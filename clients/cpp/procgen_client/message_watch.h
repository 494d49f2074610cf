#ifndef PROCGEN_CLIENT_MESSAGE_WATCH_H_
#define PROCGEN_CLIENT_MESSAGE_WATCH_H_

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "grpcpp/channel.h"
#include "procgen_client/internal/call_options.h"
#include "procgen_client/open_calls.h"

namespace procgen_client {

// A server stream of serialised messages, conflated to the latest: all are read as they arrive, so
// a slow reader skips intermediate ones. Messages are not validated.
// Threads: Next from one thread at a time; Stop from any.
class MessageWatch {
 public:
  // `path`: of a method, e.g. "/procgen.v1.PoolService/WatchPool". Has no deadline.
  MessageWatch(const std::shared_ptr<grpc::Channel>& channel, const CallOptions& options,
               const std::string& path, absl::string_view request);
  // Ends the stream.
  ~MessageWatch();
  MessageWatch(const MessageWatch&) = delete;
  MessageWatch& operator=(const MessageWatch&) = delete;

  // Waits for at most `timeout`, or without end if it is negative, for a message that was not
  // returned before. Empty: none yet. Errors: those of the server; CANCELLED after Stop. After an
  // error all calls return it.
  absl::StatusOr<std::optional<std::string>> Next(std::chrono::duration<double> timeout);
  // Makes Next return CANCELLED, also one that waits.
  void Stop();

 private:
  struct State;
  class Call;

  const std::shared_ptr<State> state_;  // shared with the call, whose last reaction still uses it
  const std::unique_ptr<Call> call_;
  const OpenCalls::Entry entry_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_MESSAGE_WATCH_H_
