// A stream's direct line: its messages past gRPC.
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/rpc/step_pool_reactor.h"
#include "server/rpc/unary_call.h"

namespace procgen {

void StepPoolReactor::OnReadBesideLine(bool ok) {
  EndAfterInbox(
      ok ? absl::InvalidArgumentError(
               "a request came by the stream, allowed while its direct line is open: there")
         : absl::OkStatus());
}

void StepPoolReactor::OnLineOpened(std::shared_ptr<DirectLine> line) {
  absl::MutexLock lock(&mutex_);
  if (finished_) {
    line->HangUp();
    return;
  }
  line_ = std::move(line);
  requests_.AbandonRead();
}

bool StepPoolReactor::OnLineMessage(const absl::StatusOr<absl::string_view>& message) {
  if (!message.ok()) {
    const bool is_end = absl::IsCancelled(message.status());
    EndAfterInbox(is_end ? absl::OkStatus() : message.status());
    Drive();
    return false;
  }
  StreamRequest* request = nullptr;
  {
    const auto has_room = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return requests_.CanRead() || requests_.IsOver();
    };
    absl::MutexLock lock(&mutex_, absl::Condition(&has_room));
    if (!requests_.CanRead()) {
      return false;
    }
    requests_.BeginRead();
    request = requests_.EndRead(true);
  }
  request->arrival_time = SteadyNow();
  sessions_->metrics().AddReceivedBytes(static_cast<int64_t>(message->size()));
  TakeIn(request, ParseMessage(*message, &request->message));
  return true;
}

bool StepPoolReactor::WriteToLine(DirectLine* line, const Outgoing& outgoing) {
  std::vector<absl::string_view> pieces;
  std::vector<grpc::Slice> slices;
  if (!outgoing.bytes.Valid()) {
    // It bears no observations: those are in shared memory.
    outgoing.response->message.SerializeToString(&line_bytes_);
    pieces.push_back(line_bytes_);
  } else if (outgoing.bytes.Dump(&slices).ok()) {
    for (const grpc::Slice& slice : slices) {
      pieces.emplace_back(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
  }
  size_t bytes = 0;
  for (const absl::string_view piece : pieces) {
    bytes += piece.size();
  }
  sessions_->metrics().AddSentBytes(static_cast<int64_t>(bytes));
  return line->Send(pieces);
}

}  // namespace procgen
