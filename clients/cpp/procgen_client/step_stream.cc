#include "procgen_client/step_stream.h"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "procgen_client/internal/call_end.h"
#include "procgen_client/internal/grpc_error.h"
#include "procgen_client/internal/timing.h"

namespace procgen_client {
namespace {

// Bounds of the default chunk count, for a server and a learner that share all cores. Smaller
// chunks, in bytes of observations, cost more than they save; more chunks save nothing
// (procgen-benchmark-stream, step/...).
constexpr int64_t kChunkBytesMin = 2 << 20;
constexpr int64_t kDefaultChunkCountMax = 4;

// Not absl::Now, which jumps when the system clock is set.
using Steady = std::chrono::steady_clock;

// Whether two responses to attach can be from the same pool.
bool IsSamePool(const procgen::v1::Pool& one, const procgen::v1::Pool& other) {
  return one.spec().env_count() == other.spec().env_count() &&
         one.spec().encoding() == other.spec().encoding() &&
         one.spec().transport() == other.spec().transport() &&
         one.spec().autoreset_mode() == other.spec().autoreset_mode() &&
         std::equal(one.observation_shape().begin(), one.observation_shape().end(),
                    other.observation_shape().begin(), other.observation_shape().end());
}

int32_t DefaultChunkCount(const procgen::v1::Pool& pool) {
  if (pool.spec().transport() == procgen::v1::TRANSPORT_SHARED_MEMORY) {
    return 1;  // no values are sent
  }
  const int64_t bytes = int64_t{pool.observation_bytes()} * pool.spec().env_count();
  return static_cast<int32_t>(
      std::clamp(bytes / kChunkBytesMin, int64_t{1}, kDefaultChunkCountMax));
}

class Backoff {
 public:
  absl::Duration Next() {
    const absl::Duration delay = delay_ * std::uniform_real_distribution<>(0.5, 1.5)(random_);
    delay_ = std::min(2 * delay_, kResumeBackoffMax);
    return delay;
  }

 private:
  absl::Duration delay_ = kResumeBackoffMin;
  std::minstd_rand random_{std::random_device()()};
};

}  // namespace

StepStream::StepStream(procgen::v1::StepService::Stub* stub, const CallOptions& call_options,
                       const std::string& pool, const StreamOptions& options)
    : stub_(stub),
      token_(call_options.token),
      attach_timeout_(call_options.timeout),
      cancellation_(std::make_shared<Cancellation>(call_options.is_cancelled)),
      reconnect_timeout_(options.reconnect_timeout),
      wants_pipe_transport_(options.pipe_transport),
      chunk_count_(options.chunk_count),
      held_(options.held_batches == nullptr ? std::make_shared<HeldBatches>()
                                            : options.held_batches) {
  procgen::v1::Attach* attach = attach_.mutable_attach();
  attach->set_pool(pool);
  attach->set_requests_in_flight_max(options.requests_in_flight_max);
  attach->set_response_bytes_max(options.response_bytes_max);
  attach->set_resumable(resumes());
  attach->set_take_over(options.take_over);
  attach->set_held_batches_max(options.held_batches_max);
}

StepStream::~StepStream() { Close().IgnoreError(); }

absl::Status StepStream::Attach() {
  absl::MutexLock sending(&send_mutex_);
  bool is_broken = false;
  if (absl::Status status = Open(attach_timeout_, &attached_, &is_broken); !status.ok()) {
    return FinishWith(std::move(status));
  }
  next_sequence_number_ = attached_.next_sequence_number();
  answered_sequence_number_ = next_sequence_number_ - 1;
  const procgen::v1::Encoding encoding = pool().spec().encoding();
  if (encoding != procgen::v1::ENCODING_UNSPECIFIED && encoding != procgen::v1::ENCODING_RAW) {
    absl::StatusOr<ObservationDecoder> decoder = ObservationDecoder::Make(pool());
    if (!decoder.ok()) {
      return GiveUp(decoder.status());
    }
    decoder_ = std::make_unique<ObservationDecoder>(*std::move(decoder));
  }
  if (chunk_count_ == 0) {
    chunk_count_ = DefaultChunkCount(pool());
  }
  // After a broken connection the attached stream is this one, which the server may not have
  // noticed.
  attach_.mutable_attach()->set_take_over(true);
  return absl::OkStatus();
}

absl::Status StepStream::Open(absl::Duration timeout, procgen::v1::Attached* attached,
                              bool* is_broken) {
  *is_broken = false;
  const bool was_attached = attached_.has_pool();
  auto connection = std::make_shared<StreamConnection>(cancellation_, token_, was_attached);
  const std::vector<int32_t> held = held_->TakeHeld();
  attach_.mutable_attach()->mutable_held_batches()->Assign(held.begin(), held.end());
  procgen::v1::StepPoolResponse response;
  {
    // A timer, because a deadline of the call would apply to the whole stream.
    const CallTimer timer(connection->context(), timeout);
    if (!connection->Start(stub_, attach_) || !connection->Read(&response)) {
      absl::Status status = EndOf(connection, is_broken);
      *is_broken = *is_broken || timer.is_due();
      return timer.is_due()
                 ? absl::DeadlineExceededError(absl::StrCat(
                       "the server did not answer attach within ", absl::FormatDuration(timeout)))
                 : status;
    }
  }
  absl::Status status = absl::InternalError("the server's first response does not answer attach");
  if (response.has_attached()) {
    status = Accept(response.attached());
  }
  if (!status.ok()) {
    return status;
  }
  if (wants_pipe_transport_) {
    connection->OpenPipes(response.attached());
  }
  {
    absl::MutexLock lock(&mutex_);
    connection_ = connection;
  }
  attached->Swap(response.mutable_attached());
  return absl::OkStatus();
}

absl::Status StepStream::Accept(const procgen::v1::Attached& attached) {
  if (absl::Status status = ValidateAttached(attach_.attach(), attached); !status.ok()) {
    return status;
  }
  if (attached_.has_pool() && !IsSamePool(pool(), attached.pool())) {
    return absl::AbortedError(
        absl::StrCat("pool ", attached.pool().name(),
                     " has other environments or observations than the pool that this stream "
                     "was attached to: it is another pool of the same name"));
  }
  if (absl::Status status = MapShared(attached); !status.ok()) {
    return status;
  }
  validator_ = ResponseValidator(attached, mapping_ == nullptr ? 0 : mapping_->batch_count());
  return absl::OkStatus();
}

absl::Status StepStream::MapShared(const procgen::v1::Attached& attached) {
  if (!attached.has_shared_memory()) {
    return absl::OkStatus();
  }
  const procgen::v1::SharedMemory& memory = attached.shared_memory();
  if (mapping_ != nullptr && mapping_->path() != memory.path()) {
    return absl::AbortedError(
        absl::StrCat("pool ", attached.pool().name(), " shares ", memory.path(),
                     ", and the pool that this stream was attached to shares ", mapping_->path(),
                     ": it is another pool of the same name"));
  }
  // The memory grows if another stream asks for more batches. Held batches keep their old mapping.
  absl::StatusOr<std::shared_ptr<const SharedMapping>> mapping =
      SharedMapping::Open(memory, attached.pool());
  if (!mapping.ok()) {
    return mapping.status();
  }
  mapping_ = *std::move(mapping);
  return absl::OkStatus();
}

absl::Status StepStream::CheckHeld(int64_t unanswered) const {
  if (mapping_ == nullptr || held_->count() + unanswered < mapping_->batch_count()) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat(
      held_->count(), " Batches are held and ", unanswered, " requests unanswered, and pool ",
      pool().name(), " has ", mapping_->batch_count(),
      " in shared memory: release some, or set StreamOptions::held_batches_max"));
}

absl::Status StepStream::Reconnect() {
  // Keeps other threads from writing to the broken stream.
  absl::MutexLock sending(&send_mutex_);
  bool is_broken = false;
  absl::Status status = EndOf(connection(), &is_broken);
  const Steady::time_point begin = Steady::now();
  Backoff backoff;
  while (is_broken) {
    const absl::Duration delay = backoff.Next();
    const absl::Duration left =
        reconnect_timeout_ - absl::FromChrono(Steady::now() - begin) - delay;
    if (left <= absl::ZeroDuration()) {
      return FinishWith(absl::UnavailableError(
          absl::StrCat("the connection broke and could not be made again within ",
                       absl::FormatDuration(reconnect_timeout_), ": ", status.message())));
    }
    if (!cancellation_->Sleep(delay)) {
      return FinishWith(absl::CancelledError("the wait for the server was cancelled"));
    }
    status = Resume(left, &is_broken);
    if (status.ok()) {
      return status;
    }
  }
  return FinishWith(std::move(status));
}

absl::Status StepStream::Resume(absl::Duration timeout, bool* is_broken) {
  procgen::v1::Attached attached;
  if (absl::Status status = Open(timeout, &attached, is_broken); !status.ok()) {
    if (absl::IsNotFound(status)) {
      return absl::NotFoundError(absl::StrCat(
          status.message(),
          ": the server was restarted while this stream was disconnected, or the "
          "pool's lease ran out; create a pool and restore the states of a checkpoint"));
    }
    return status;
  }
  const std::shared_ptr<StreamConnection> connection = this->connection();
  const int64_t next = attached.next_sequence_number();
  if (next <= answered_sequence_number_ || next > next_sequence_number_) {
    connection->context()->TryCancel();
    return absl::AbortedError(absl::StrCat(
        "pool ", attached.pool().name(), " is at request ", next, ", and this stream left it ",
        "between ", answered_sequence_number_ + 1, " and ", int64_t{next_sequence_number_},
        ": another client has stepped it, or it is another pool of the same name"));
  }
  std::deque<procgen::v1::StepPoolRequest> unanswered;
  {
    absl::MutexLock lock(&mutex_);
    unanswered = unanswered_;
  }
  for (procgen::v1::StepPoolRequest& request : unanswered) {
    request.clear_released_batches();  // attaching has released all batches that are not held
    if (!connection->Write(request)) {
      return EndOf(connection, is_broken);
    }
  }
  return absl::OkStatus();
}

absl::Status StepStream::EndOf(const std::shared_ptr<StreamConnection>& connection,
                               bool* is_broken) {
  grpc::Status end;
  *is_broken = false;
  if (absl::Status status = connection->AwaitEndAfterFailure(&end); !status.ok()) {
    return status;
  }
  *is_broken = IsBrokenConnection(end, *connection->context());
  return end.ok() ? absl::UnavailableError("the server ended the stream") : ToAbslStatus(end);
}

std::shared_ptr<StreamConnection> StepStream::connection() {
  absl::MutexLock lock(&mutex_);
  return connection_;
}

absl::Status StepStream::Step(absl::Span<const int32_t> actions, Batch* batch,
                              std::vector<procgen::v1::Annotation> annotations) {
  return Call(StepRequest(actions, std::move(annotations)), batch);
}

absl::StatusOr<int64_t> StepStream::SendStep(absl::Span<const int32_t> actions,
                                             std::vector<procgen::v1::Annotation> annotations) {
  return Send(StepRequest(actions, std::move(annotations)));
}

procgen::v1::StepPoolRequest StepStream::StepRequest(
    absl::Span<const int32_t> actions, std::vector<procgen::v1::Annotation> annotations) {
  procgen::v1::StepPoolRequest request;
  {
    absl::MutexLock lock(&mutex_);
    std::swap(request, answered_);
  }
  procgen::v1::Step* step = request.mutable_step();
  step->Clear();
  step->mutable_actions()->Assign(actions.begin(), actions.end());
  step->set_chunk_count(chunk_count_);
  for (procgen::v1::Annotation& annotation : annotations) {
    *step->add_annotations() = std::move(annotation);
  }
  return request;
}

absl::Status StepStream::Observe(Batch* batch) {
  procgen::v1::StepPoolRequest request;
  request.mutable_observe();
  return Call(std::move(request), batch);
}

absl::Status StepStream::SetLevelSampler(procgen::v1::LevelSampler level_sampler) {
  procgen::v1::StepPoolRequest request;
  request.mutable_level_sampler()->Swap(&level_sampler);
  Batch none;
  return Call(std::move(request), &none);
}

absl::Status StepStream::Call(procgen::v1::StepPoolRequest request, Batch* batch) {
  if (absl::Status status = Over(); !status.ok()) {
    return status;
  }
  if (next_sequence_number_ - 1 != answered_sequence_number_) {
    return absl::FailedPreconditionError("requests are unanswered; receive their answers first");
  }
  batch->shared_ = nullptr;
  absl::StatusOr<int64_t> sent = Send(std::move(request));
  return sent.ok() ? Receive(batch) : sent.status();
}

absl::StatusOr<int64_t> StepStream::Send(procgen::v1::StepPoolRequest request) {
  const int64_t unanswered = next_sequence_number_ - 1 - answered_sequence_number_;
  if (unanswered >= requests_in_flight_max()) {
    return absl::FailedPreconditionError(
        absl::StrCat(unanswered, " requests are unanswered, allowed: ", requests_in_flight_max()));
  }
  absl::MutexLock sending(&send_mutex_);
  if (absl::Status status = CheckHeld(unanswered); !status.ok()) {
    return status;
  }
  if (absl::Status status = Over(); !status.ok()) {
    return status;
  }
  // Incremented before Write, because the answer may arrive before Write returns.
  const int64_t number = next_sequence_number_++;
  request.set_sequence_number(number);
  if (mapping_ != nullptr) {
    // Lets the server free batches of answers that have arrived.
    request.set_acknowledged_sequence_number(answered_sequence_number_);
  }
  held_->TakeReleased(request.mutable_released_batches());
  std::shared_ptr<StreamConnection> connection;
  const procgen::v1::StepPoolRequest* sent = nullptr;
  {
    absl::MutexLock lock(&mutex_);
    connection = connection_;
    // The pointer stays valid until the request is answered, which is after Write has used it.
    sent = &unanswered_.emplace_back(std::move(request));
  }
  connection->Write(*sent);
  return number;
}

absl::Status StepStream::Receive(Batch* batch) {
  if (absl::Status status = Over(); !status.ok()) {
    return status;
  }
  if (next_sequence_number_ - 1 == answered_sequence_number_) {
    return absl::FailedPreconditionError("no request is unanswered; send one first");
  }
  batch->shared_ = nullptr;
  absl::StatusOr<bool> is_there = ReadAnswer(batch);
  while (is_there.ok() && !*is_there) {
    absl::Status status = resumes() ? Reconnect() : Finish();
    if (!status.ok()) {
      *batch = Batch();
      return status;
    }
    is_there = ReadAnswer(batch);
  }
  // Only once the answer is complete: after a broken connection all of it is sent again.
  absl::Status status = is_there.ok() ? Understand(batch) : is_there.status();
  if (!status.ok()) {
    *batch = Batch();                      // discards invalid values
    connection()->context()->TryCancel();  // unblocks a sending thread
    absl::MutexLock sending(&send_mutex_);
    return GiveUp(std::move(status));
  }
  absl::MutexLock lock(&mutex_);
  answered_sequence_number_ = batch->sequence_number();
  std::swap(answered_, unanswered_.front());
  unanswered_.pop_front();
  return absl::OkStatus();
}

absl::StatusOr<bool> StepStream::ReadAnswer(Batch* batch) {
  std::shared_ptr<StreamConnection> connection;
  {
    absl::MutexLock lock(&mutex_);
    connection = connection_;
    validator_.Expect(unanswered_.front());
  }
  procgen::v1::StepPoolResponse* response = &batch->response_;
  while (true) {
    absl::StatusOr<bool> is_there = connection->ReadAnswer(answered_sequence_number_ + 1, response);
    if (!is_there.ok() || !*is_there) {
      return is_there;
    }
    if (absl::Status status = validator_.Validate(*response); !status.ok()) {
      return status;
    }
    if (response == &part_) {
      batch->Append(part_.batch());
    } else {
      batch->Begin();
    }
    if (validator_.is_complete()) {
      return true;
    }
    response = &part_;
  }
}

absl::Status StepStream::Understand(Batch* batch) {
  absl::Status status = batch->Decode(decoder_.get());
  if (status.ok() && batch->value().has_shared_batch()) {
    auto rows = SharedRows::Hold(mapping_, held_, batch->value());
    if (!rows.ok()) {
      return rows.status();
    }
    batch->shared_ = *std::move(rows);
  }
  return status;
}

absl::Status StepStream::Over() {
  absl::MutexLock lock(&mutex_);
  return finished_ ? status_ : absl::OkStatus();
}

absl::Status StepStream::Finish() {
  bool is_broken = false;
  return FinishWith(EndOf(connection(), &is_broken));
}

absl::Status StepStream::FinishWith(absl::Status status) {
  absl::MutexLock lock(&mutex_);
  finished_ = true;
  status_ = std::move(status);
  return status_;
}

absl::Status StepStream::GiveUp(absl::Status status) {
  const std::shared_ptr<StreamConnection> connection = this->connection();
  connection->context()->TryCancel();
  bool is_broken = false;
  EndOf(connection, &is_broken).IgnoreError();
  return FinishWith(std::move(status));
}

void StepStream::Cancel() { connection()->context()->TryCancel(); }

void StepStream::Abort() {
  cancellation_->Cancel();
  connection()->Interrupt();
}

absl::Status StepStream::Close() {
  {
    absl::MutexLock lock(&mutex_);
    if (finished_) {
      return status_;
    }
    finished_ = true;
    status_ = absl::FailedPreconditionError("the stream is closed");
  }
  const std::shared_ptr<StreamConnection> connection = this->connection();
  connection->EndRequests();
  grpc::Status end;
  absl::Status status = connection->AwaitEnd(&end);
  return status.ok() ? ToAbslStatus(end) : status;
}

}  // namespace procgen_client
