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

// Carries requests and responses by pipes between the server and a learner on the same machine. No
// thread waits for a request that comes soon: the thread that has answered polls for the next one
// first, and only after some time lets the pipe's own thread be woken by it.
// Threads: as StreamTransport; OnInput is called by the pipe's thread.
class PipeTransport final : public StreamTransport {
 public:
  // `user` and `metrics` must outlive it.
  PipeTransport(std::shared_ptr<PipeConnection> pipes, StreamTransportUser* user, Metrics* metrics);

  // As that of PipeConnectionUser: there may be input for a read that was awaited.
  void OnInput();
  // Ends the pipes for both sides.
  void HangUp() { pipes_->HangUp(); }

  bool Read() override;
  void Await() override;
  absl::Status Take(StreamRequest* request) override;
  void Write(Outgoing* outgoing) override;

 private:
  // Receives a request, if one is there, and reports it.
  bool Poll();
  // Has OnInput called when there is one.
  void Watch();

  const std::shared_ptr<PipeConnection> pipes_;
  StreamTransportUser* const user_;
  Metrics* const metrics_;
  // Of the read that is under way:
  absl::StatusOr<std::optional<absl::string_view>> received_;
  int polls_to_skip_ = 0;                 // set after a fruitless spin
  std::atomic<bool> is_watched_ = false;  // the read is left to OnInput
  // Of the write that is under way; its memory is kept.
  std::string serialized_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_PIPE_TRANSPORT_H_
