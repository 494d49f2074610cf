#ifndef SERVER_RPC_STEP_PIPE_TRANSPORT_H_
#define SERVER_RPC_STEP_PIPE_TRANSPORT_H_

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/metrics/metrics.h"
#include "server/rpc/step/stream_transport.h"
#include "server/shared_memory/pipe_connection.h"

namespace procgen {

// A transport over pipes, for a learner on the same machine. The thread that sent a response first
// polls for the next request, because waking a thread costs more. Only then does the pipe's own
// thread wait for it.
// Threads: as StreamTransport; the pipe's thread calls OnInput.
class PipeTransport final : public StreamTransport {
 public:
  // `user` and `metrics` must outlive it.
  PipeTransport(std::shared_ptr<PipeConnection> pipes, StreamTransportUser* user, Metrics* metrics);

  // Like PipeConnectionUser::OnPipesInput: there may be input for a read passed to Await.
  void OnInput();
  // Closes the pipes for both sides.
  void HangUp() { pipes_->HangUp(); }

  bool Read() override;
  void Await() override;
  absl::Status Parse(StreamRequest* request) override;
  void Write(Outgoing* outgoing) override;

 private:
  // Receives and reports a request. Returns false if none has arrived.
  bool Poll();
  // Makes the pipe's thread call OnInput when there is input.
  void Watch();

  const std::shared_ptr<PipeConnection> pipes_;
  StreamTransportUser* const user_;
  Metrics* const metrics_;
  // State of the current read.
  absl::StatusOr<std::optional<absl::string_view>> received_;
  int polls_to_skip_ = 0;                 // set after a fruitless spin
  std::atomic<bool> is_watched_ = false;  // OnInput continues the read
  // Of the current write. A member, so that its memory is reused.
  std::string serialized_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_PIPE_TRANSPORT_H_
