#include "server/rpc/step/pipe_transport.h"

#include <cstddef>
#include <cstdint>
#include <thread>
#include <utility>
#include <vector>

#include "grpcpp/support/slice.h"
#include "server/rpc/grpc/parse_message.h"

namespace procgen {
namespace {

// Polls of the pipe before its thread waits for input. They take some 5 us, less than waking a
// thread.
constexpr int kSpinIterations = 16;
// Requests that are not polled for after a fruitless spin.
constexpr int kPollsSkipped = 64;

}  // namespace

PipeTransport::PipeTransport(std::shared_ptr<PipeConnection> pipes, StreamTransportUser* user,
                             Metrics* metrics)
    : pipes_(std::move(pipes)), user_(user), metrics_(metrics) {}

bool PipeTransport::Poll() {
  received_ = pipes_->Receive();
  if (received_.ok() && !received_->has_value()) {
    return false;
  }
  const absl::Status status = received_.status();  // the next read may begin within OnRead
  user_->OnRead(this, status);
  return true;
}

bool PipeTransport::Read() { return Poll(); }

void PipeTransport::Await() {
  if (polls_to_skip_ > 0) {
    --polls_to_skip_;
  } else {
    for (int i = 0; i < kSpinIterations; ++i) {
      if (Poll()) {
        return;
      }
      std::this_thread::yield();
    }
    polls_to_skip_ = kPollsSkipped;
  }
  Watch();
}

void PipeTransport::Watch() {
  is_watched_ = true;
  pipes_->Watch();
}

void PipeTransport::OnInput() {
  // The pipe's thread also calls this after a hang-up, when another thread may be polling.
  if (is_watched_.exchange(false) && !Poll()) {
    Watch();
  }
}

absl::Status PipeTransport::Parse(StreamRequest* request) {
  const absl::string_view bytes = **received_;
  request->message_bytes = bytes.size();
  metrics_->AddReceivedBytes(static_cast<int64_t>(bytes.size()));
  return ParseMessage(bytes, &request->message);
}

void PipeTransport::Write(Outgoing* outgoing) {
  std::vector<absl::string_view> pieces;
  std::vector<grpc::Slice> slices;
  if (!outgoing->bytes.Valid()) {
    // The observations are in shared memory, not in the response.
    outgoing->response->message.SerializeToString(&serialized_);
    pieces.emplace_back(serialized_);
  } else if (outgoing->bytes.Dump(&slices).ok()) {
    for (const grpc::Slice& slice : slices) {
      pieces.emplace_back(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
  }
  size_t bytes = 0;
  for (const absl::string_view piece : pieces) {
    bytes += piece.size();
  }
  metrics_->AddSentBytes(static_cast<int64_t>(bytes));
  user_->OnWritten(pipes_->Send(pieces));
}

}  // namespace procgen
