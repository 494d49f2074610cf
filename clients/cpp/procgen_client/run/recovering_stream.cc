#include "procgen_client/run/recovering_stream.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "grpcpp/impl/codegen/proto_utils.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

// Longest wait for an event, after which Cancel and the times are looked at.
constexpr absl::Duration kPollInterval = absl::Milliseconds(50);
// Backoff between attempts to continue a pool; doubles each time.
constexpr absl::Duration kResumeBackoffMin = absl::Milliseconds(20);
constexpr absl::Duration kResumeBackoffMax = absl::Milliseconds(500);
// Requests that are repeated ahead of their responses.
constexpr size_t kReplayWindow = 32;
// Saving an environment takes some 60 us, so a checkpoint of n takes 1 % of n times this.
constexpr absl::Duration kIntervalPerEnvironment = absl::Milliseconds(6);
// Requests since the checkpoint, in bytes, after which the next checkpoint is due at once.
constexpr int64_t kLogBytesMax = 64 << 20;
// Most snapshots are smaller.
constexpr int64_t kStateBytes = 16 << 10;
constexpr int64_t kStatesPerRequestMax = 1024;

bool ChangesNothing(const v1::RunPoolRequest& request) {
  return request.has_observe() || request.has_save_states() || request.has_render();
}

// Removes what a repeated request does not need.
void Strip(v1::RunPoolRequest* request) {
  if (request->has_step()) {
    request->mutable_step()->set_acknowledge_only(true);
    request->mutable_step()->clear_annotations();
  } else if (request->has_reset()) {
    request->mutable_reset()->set_acknowledge_only(true);
  }
}

// Whether a call ended because of a request, which has changed nothing.
bool IsRejection(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kUnimplemented:
      return true;
    default:
      return false;
  }
}

absl::Status Parse(grpc::ByteBuffer* bytes, v1::RunPoolResponse* response) {
  return grpc::SerializationTraits<v1::RunPoolResponse>::Deserialize(bytes, response).ok()
             ? absl::OkStatus()
             : absl::DataLossError("the server's response is malformed");
}

}  // namespace

int32_t StatesPerRequest(int64_t response_bytes_max) {
  return static_cast<int32_t>(
      std::clamp<int64_t>(response_bytes_max / kStateBytes, 1, kStatesPerRequestMax));
}

absl::Time SteadyNow() {
  return absl::FromUnixNanos(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                 std::chrono::steady_clock::now().time_since_epoch())
                                 .count());
}

RunClock RunClock::Steady() {
  return {.now = SteadyNow, .sleep = [](absl::Duration duration) {
            std::this_thread::sleep_for(absl::ToChronoNanoseconds(duration));
          }};
}

RecoveringStream::RecoveringStream(v1::StartPool start, const RecoveryOptions& options,
                                   OpenRunStream open, RunClock clock)
    : start_(std::move(start)),
      options_(options),
      open_(std::move(open)),
      clock_(std::move(clock)),
      states_per_request_(StatesPerRequest(options.response_bytes_max)) {}

RecoveringStream::~RecoveringStream() = default;

absl::StatusOr<v1::Started> RecoveringStream::Start() {
  while (ended_.ok() && !started_.has_value()) {
    // There are no requests yet, so it returns at the deadline or at the end.
    Advance(clock_.now() + kPollInterval);
  }
  if (!ended_.ok()) {
    return ended_;
  }
  checkpoint_time_ = clock_.now();
  return *started_;
}

void RecoveringStream::Send(v1::RunPoolRequest request) {
  Entry& entry = log_.emplace_back();
  entry.bytes = static_cast<int64_t>(request.ByteSizeLong());
  entry.request = std::move(request);
  log_bytes_ += entry.bytes;
  ++unanswered_count_;
  if (stream_ != nullptr) {
    WriteMore();
    TakeCheckpointIfDue();
  }
}

std::optional<absl::StatusOr<grpc::ByteBuffer>> RecoveringStream::Receive(absl::Duration timeout) {
  auto response = Advance(timeout == absl::InfiniteDuration() ? absl::InfiniteFuture()
                                                              : clock_.now() + timeout);
  if (response.has_value() && response->ok()) {
    TakeCheckpointIfDue();
  }
  return response;
}

std::optional<absl::StatusOr<grpc::ByteBuffer>> RecoveringStream::Advance(absl::Time deadline) {
  while (true) {
    if (!ended_.ok()) {
      return ended_;
    }
    if (stream_ == nullptr) {
      if (!Open(deadline) && ended_.ok()) {
        return std::nullopt;
      }
      continue;
    }
    WriteMore();
    const absl::Duration left = std::max(deadline - clock_.now(), absl::ZeroDuration());
    switch (stream_->Next(std::min(left, kPollInterval))) {
      case RunStream::Event::kNone:
        if (IsOver(deadline)) {
          return std::nullopt;
        }
        break;
      case RunStream::Event::kWritten:
        is_writing_ = false;
        break;
      case RunStream::Event::kResponse:
        if (auto response = OnResponse(); response.has_value()) {
          return response;
        }
        if (started_.has_value() && log_.empty()) {
          return std::nullopt;  // to Start
        }
        break;
      case RunStream::Event::kEnd:
        if (std::optional<absl::Status> rejected = OnEnd(); rejected.has_value()) {
          return *std::move(rejected);
        }
        break;
    }
  }
}

bool RecoveringStream::Open(absl::Time deadline) {
  const absl::Time now = clock_.now();
  if (lost_time_.has_value() && now - *lost_time_ >= options_.reconnect_timeout) {
    SetEnded(absl::UnavailableError(absl::StrCat(
        "the connection broke and could not be made again within ",
        absl::FormatDuration(options_.reconnect_timeout), ": ", lost_status_.message())));
    return false;
  }
  if (next_open_time_ > now) {
    clock_.sleep(
        std::clamp(std::min(next_open_time_, deadline) - now, absl::ZeroDuration(), kPollInterval));
    return !IsCancelled() && clock_.now() < deadline;
  }
  prologue_.clear();
  prologue_.emplace_back();
  *prologue_.back().mutable_start() = start_;
  int64_t bytes = options_.request_bytes_max;  // the first state begins a request
  for (const v1::State& state : checkpoint_) {
    const auto state_bytes = static_cast<int64_t>(state.ByteSizeLong()) + 16;
    if (bytes + state_bytes > options_.request_bytes_max / 2) {
      prologue_.emplace_back();
      bytes = 0;
    }
    *prologue_.back().mutable_restore_states()->add_states() = state;
    bytes += state_bytes;
  }
  prologue_written_ = 0;
  next_write_ = log_begin_;
  ++call_count_;
  attempt_begin_ = now;
  is_created_ = false;
  std::unique_ptr<RunStream> stream = open_(attempt_++);
  const std::lock_guard lock(stream_mutex_);
  stream_ = std::move(stream);
  if (cancelled_) {
    stream_->Cancel();
  }
  return true;
}

void RecoveringStream::WriteMore() {
  if (is_writing_) {
    return;
  }
  if (prologue_written_ < prologue_.size()) {
    in_flight_.push_back(-1 - static_cast<int64_t>(prologue_written_));
    is_writing_ = true;
    stream_->Write(prologue_[prologue_written_++]);
    return;
  }
  while (next_write_ < log_end() && At(next_write_).is_dropped) {
    ++next_write_;
  }
  if (next_write_ == log_end() ||
      (At(next_write_).is_answered && in_flight_.size() >= kReplayWindow)) {
    return;
  }
  in_flight_.push_back(next_write_);
  is_writing_ = true;
  stream_->Write(At(next_write_++).request);
}

bool RecoveringStream::IsRecovering() {
  return prologue_written_ < prologue_.size() ||
         std::any_of(in_flight_.begin(), in_flight_.end(),
                     [this](int64_t number) { return number < 0 || At(number).is_answered; }) ||
         (next_write_ < log_end() && At(next_write_).is_answered);
}

std::optional<absl::StatusOr<grpc::ByteBuffer>> RecoveringStream::OnResponse() {
  if (in_flight_.empty()) {
    SetEnded(absl::DataLossError("the server sent a response without a request"));
    return std::nullopt;
  }
  const int64_t number = in_flight_.front();
  in_flight_.pop_front();
  if (number == -1) {
    is_created_ = true;
    attempt_ = 0;
    if (absl::Status status = OnStarted(); !status.ok()) {
      SetEnded(std::move(status));
    }
    return std::nullopt;
  }
  const bool is_repeated = number < 0 || At(number).is_answered;
  // A request that breaks every call is repeated until reconnect_timeout.
  if (lost_time_.has_value() && (!is_repeated || unanswered_count_ == 0) && !IsRecovering()) {
    lost_time_ = std::nullopt;
    backoff_ = absl::ZeroDuration();
  }
  if (is_repeated) {
    return std::nullopt;
  }
  Entry& entry = At(number);
  entry.is_answered = true;
  if (entry.is_checkpoint) {
    v1::RunPoolResponse response;
    if (absl::Status status = Parse(&stream_->response(), &response); !status.ok()) {
      SetEnded(std::move(status));
    } else {
      OnSaved(response.states(), number);
    }
    return std::nullopt;
  }
  --unanswered_count_;
  if (ChangesNothing(entry.request)) {
    entry.is_dropped = true;
    entry.request.Clear();
  } else {
    Strip(&entry.request);
  }
  return std::move(stream_->response());
}

absl::Status RecoveringStream::OnStarted() {
  v1::RunPoolResponse response;
  if (absl::Status status = Parse(&stream_->response(), &response); !status.ok()) {
    return status;
  }
  if (!response.has_started()) {
    return absl::DataLossError("the server's first response has no started");
  }
  const v1::Started& started = response.started();
  if (!started_.has_value()) {
    started_ = started;
    return absl::OkStatus();
  }
  if (started.server_version() != started_->server_version() ||
      started.art_fingerprint() != started_->art_fingerprint()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the pool cannot continue on this server: it has version ", started.server_version(),
        " and art ", absl::Hex(started.art_fingerprint()), ", the one before had version ",
        started_->server_version(), " and art ", absl::Hex(started_->art_fingerprint())));
  }
  return absl::OkStatus();
}

void RecoveringStream::OnSaved(const v1::States& states, int64_t number) {
  saved_.insert(saved_.end(), states.states().begin(), states.states().end());
  if (number != checkpoint_end_) {
    return;
  }
  checkpoint_ = std::move(saved_);
  saved_.clear();
  checkpoint_end_ = -1;
  checkpoint_time_ = clock_.now();
  ++checkpoint_count_;
  DropUpTo(number);
  if (options_.has_better_server != nullptr && options_.has_better_server()) {
    ForgetCall();  // opens the next one from this checkpoint
  }
}

void RecoveringStream::DropUpTo(int64_t number) {
  while (log_begin_ <= number) {
    Entry& entry = log_.front();
    if (entry.request.has_level_sampler() && !entry.is_dropped) {
      *start_.mutable_spec()->mutable_level_sampler() =
          std::move(*entry.request.mutable_level_sampler());
    }
    log_bytes_ -= entry.bytes;
    log_.pop_front();
    ++log_begin_;
  }
}

std::optional<absl::Status> RecoveringStream::OnEnd() {
  const absl::Status status = stream_->status();
  const bool is_lost = stream_->is_lost();
  const bool was_recovering = IsRecovering();
  const int64_t oldest = in_flight_.empty() ? -1 : in_flight_.front();
  ForgetCall();
  if (IsCancelled()) {
    return std::nullopt;
  }
  // The pool of the call before may not be gone yet.
  const bool is_name_taken = started_.has_value() && absl::IsAlreadyExists(status);
  const bool is_full = started_.has_value() && was_recovering && absl::IsResourceExhausted(status);
  if (is_lost || is_name_taken || is_full) {
    if (!started_.has_value() || options_.reconnect_timeout <= absl::ZeroDuration()) {
      SetEnded(status);
      return std::nullopt;
    }
    if (is_name_taken) {
      start_.clear_pool_id();
    }
    const absl::Time now = clock_.now();
    lost_time_ = lost_time_.value_or(now);
    lost_status_ = status;
    next_open_time_ = now + backoff_;
    backoff_ = std::clamp(2 * backoff_, kResumeBackoffMin, kResumeBackoffMax);
    return std::nullopt;
  }
  if (was_recovering || oldest < 0 || !IsRejection(status)) {
    SetEnded(status);
    return std::nullopt;
  }
  if (At(oldest).is_checkpoint) {
    // Its response is too large.
    if (states_per_request_ == 1) {
      SetEnded(status);
    }
    states_per_request_ = (states_per_request_ + 1) / 2;
    return std::nullopt;
  }
  // The oldest request was rejected and has changed nothing.
  At(oldest).is_answered = true;
  At(oldest).is_dropped = true;
  --unanswered_count_;
  return status;
}

void RecoveringStream::ForgetCall() {
  {
    std::unique_ptr<RunStream> ended;  // destroyed without the lock
    const std::lock_guard lock(stream_mutex_);
    ended.swap(stream_);
  }
  in_flight_.clear();
  is_writing_ = false;
  // A checkpoint is complete or does not exist.
  saved_.clear();
  checkpoint_end_ = -1;
  for (Entry& entry : log_) {
    entry.is_dropped |= entry.is_checkpoint;
  }
}

void RecoveringStream::TakeCheckpointIfDue() {
  if (stream_ == nullptr || checkpoint_end_ >= 0 || log_.empty()) {
    return;
  }
  const int32_t env_count = start_.spec().env_count();
  const absl::Duration interval =
      std::max(options_.checkpoint_interval, env_count * kIntervalPerEnvironment);
  const absl::Duration elapsed = clock_.now() - checkpoint_time_;
  const bool is_due = unanswered_count_ == 0 ? elapsed >= interval : elapsed >= 2 * interval;
  if ((!is_due && log_bytes_ < kLogBytesMax) || IsRecovering()) {
    return;
  }
  for (int32_t first = 0; first < env_count; first += states_per_request_) {
    Entry& entry = log_.emplace_back();
    entry.is_checkpoint = true;
    for (int32_t i = first; i < std::min(first + states_per_request_, env_count); ++i) {
      entry.request.mutable_save_states()->add_environments(i);
    }
  }
  checkpoint_end_ = log_end() - 1;
  WriteMore();
}

void RecoveringStream::Close(absl::Duration timeout) {
  const absl::Time deadline = clock_.now() + timeout;
  bool is_half_closed = false;
  while (stream_ != nullptr && ended_.ok() && !cancelled_ && clock_.now() < deadline) {
    if (!is_writing_ && !is_half_closed) {
      stream_->HalfClose();
      is_half_closed = true;
    }
    const RunStream::Event event = stream_->Next(std::min(timeout, kPollInterval));
    is_writing_ &= event != RunStream::Event::kWritten;
    if (event == RunStream::Event::kEnd) {
      break;
    }
  }
  SetEnded(absl::FailedPreconditionError("the pool is closed"));
}

bool RecoveringStream::IsOver(absl::Time deadline) {
  if (IsCancelled()) {
    return false;
  }
  const absl::Time now = clock_.now();
  if ((lost_time_.has_value() && now - *lost_time_ > options_.reconnect_timeout) ||
      (!is_created_ && now - attempt_begin_ > options_.attempt_timeout)) {
    stream_->Cancel();
    return false;
  }
  return now >= deadline;
}

bool RecoveringStream::IsCancelled() {
  if (cancelled_) {
    SetEnded(absl::CancelledError("the connection was closed by this client"));
  }
  return cancelled_;
}

void RecoveringStream::Cancel() {
  cancelled_ = true;
  const std::lock_guard lock(stream_mutex_);
  if (stream_ != nullptr) {
    stream_->Cancel();
  }
}

void RecoveringStream::SetEnded(absl::Status status) {
  ended_ = std::move(status);
  const std::lock_guard lock(stream_mutex_);
  if (stream_ != nullptr) {
    stream_->Cancel();
  }
}

}  // namespace procgen_client
