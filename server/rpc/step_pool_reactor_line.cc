// A stream's direct line: its messages past gRPC.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/rpc/parse_message.h"
#include "server/rpc/step_pool_reactor.h"

namespace procgen {
namespace {

// How often it is looked whether a learner that has just been answered asks on at once: some 5 us,
// less than it costs to wake a thread for its request. For how many requests that is not done after
// it was in vain.
constexpr int kLooksForNext = 16;
constexpr int kRequestsNotLookedFor = 64;

}  // namespace

void StepPoolReactor::OnReadBesideLine(bool ok) {
  EndAfterInbox(
      ok ? absl::InvalidArgumentError(
               "a request came by the stream, allowed while its direct line is open: there")
         : absl::OkStatus());
}

void StepPoolReactor::OnLineOpened(std::shared_ptr<DirectLine> line) {
  {
    absl::MutexLock lock(&mutex_);
    if (finished_) {
      line->HangUp();
      return;
    }
    line_ = std::move(line);
    requests_.AbandonRead();
  }
  Drive();
}

void StepPoolReactor::OnLineInput() {
  {
    absl::MutexLock lock(&mutex_);
    line_input_ = LineInput::kUnknown;
  }
  Drive();
}

bool StepPoolReactor::WantsLine() const {
  return line_ != nullptr && turn_of_ == nullptr && requests_.CanRead();
}

void StepPoolReactor::ReadLine() {
  std::shared_ptr<DirectLine> line;
  bool is_answered = false;
  {
    absl::MutexLock lock(&mutex_);
    line = line_;
    is_answered = !responses_.CanWrite();
  }
  TakeInFromLine(is_answered ? LookForNext(line.get()) : line->Receive());
}

void StepPoolReactor::ReadLineAhead() {
  std::shared_ptr<DirectLine> line;
  {
    absl::MutexLock lock(&mutex_);
    if (line_ == nullptr || !requests_.CanRead()) {
      return;
    }
    requests_.BeginRead();
    line = line_;
  }
  TakeInFromLine(line->Receive());
}

void StepPoolReactor::TakeInFromLine(const LineMessage& message) {
  StreamRequest* request = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    if (message.ok() && !message->has_value()) {
      requests_.AbandonRead();
      return;
    }
    line_input_ = LineInput::kUnknown;
    request = requests_.EndRead(message.ok());
  }
  if (!message.ok()) {
    const bool is_end = absl::IsCancelled(message.status());
    EndAfterInbox(is_end ? absl::OkStatus() : message.status());
  }
  if (request == nullptr) {
    return;
  }
  request->arrival_time = SteadyNow();
  request->message_bytes = (*message)->size();
  sessions_->metrics().AddReceivedBytes(static_cast<int64_t>((*message)->size()));
  TakeIn(request, ParseMessage(**message, &request->message));
}

StepPoolReactor::LineMessage StepPoolReactor::LookForNext(DirectLine* line) {
  LineMessage message = line->Receive();
  if (not_looked_for_ > 0) {
    --not_looked_for_;
    return message;
  }
  for (int looks = 1; looks < kLooksForNext && message.ok() && !message->has_value(); ++looks) {
    std::this_thread::yield();
    message = line->Receive();
  }
  not_looked_for_ = message.ok() && !message->has_value() ? kRequestsNotLookedFor : 0;
  return message;
}

void StepPoolReactor::WatchLine() {
  std::shared_ptr<DirectLine> line;
  {
    absl::MutexLock lock(&mutex_);
    line = line_;
  }
  line->Watch();
}

bool StepPoolReactor::WriteToLine(DirectLine* line, const Outgoing& outgoing) {
  std::vector<absl::string_view> pieces;
  std::vector<grpc::Slice> slices;
  if (!outgoing.bytes.Valid()) {
    // It bears no observations: those are in shared memory.
    outgoing.response->message.SerializeToString(&line_bytes_);
    pieces.emplace_back(line_bytes_);
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
