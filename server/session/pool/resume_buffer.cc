#include "server/session/pool/resume_buffer.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {

ResumeBuffer::ResumeBuffer(std::string pool_name, int64_t answer_bytes_max, ByteBudget* budget,
                           bool shares_memory)
    : pool_name_(std::move(pool_name)),
      answer_bytes_max_(answer_bytes_max),
      budget_(budget),
      shares_memory_(shares_memory) {}

ResumeBuffer::~ResumeBuffer() {
  absl::MutexLock lock(&mutex_);
  budget_->Change(reserved_bytes_, 0);
}

absl::Status ResumeBuffer::Reserve(const AttachOptions& options) {
  if (!shares_memory_ && (options.held_batches_max != 0 || !options.held_batches.empty())) {
    return absl::InvalidArgumentError(
        absl::StrCat("attach.held_batches_max is ", options.held_batches_max,
                     " and attach.held_batches has ", options.held_batches.size(),
                     " entries, allowed: none, as pool ", pool_name_, " shares no memory"));
  }
  absl::MutexLock lock(&mutex_);
  if (absl::Status status = slots_.CheckHeld(options.held_batches); !status.ok()) {
    return status;
  }
  const int64_t bytes = options.kept_answer_count() * answer_bytes_max_;
  if (bytes > reserved_bytes_ && !budget_->Change(reserved_bytes_, bytes)) {
    return absl::ResourceExhaustedError(
        absl::StrCat("attach.resumable keeps ", options.kept_answer_count(), " answers of up to ",
                     answer_bytes_max_, " bytes, and other pools have ",
                     budget_->reserved_bytes() - reserved_bytes_,
                     ", limit resume_buffer_bytes_max is ", budget_->bytes_max()));
  }
  reserved_bytes_ = std::max(reserved_bytes_, bytes);
  return absl::OkStatus();
}

void ResumeBuffer::BeginStream(const AttachOptions& options, int64_t next_sequence_number) {
  absl::MutexLock lock(&mutex_);
  stream_ = options;
  successor_answer_count_ = 0;
  slots_.BeginStream(options.held_batches);
  if (!options.resumable) {
    kept_ = {};
    slots_.ForgetUpTo(next_sequence_number);
  }
  TrimReservation();
}

void ResumeBuffer::SetSuccessor(const AttachOptions& options) {
  absl::MutexLock lock(&mutex_);
  successor_answer_count_ = options.kept_answer_count();
}

void ResumeBuffer::GrowBatches(int32_t batch_count) {
  absl::MutexLock lock(&mutex_);
  slots_.Grow(batch_count);
}

void ResumeBuffer::TrimReservation() {
  const int64_t count = std::max(
      {stream_.kept_answer_count(), successor_answer_count_, static_cast<int32_t>(kept_.size())});
  if (const int64_t bytes = count * answer_bytes_max_; bytes < reserved_bytes_) {
    budget_->Change(reserved_bytes_, bytes);
    reserved_bytes_ = bytes;
  }
}

absl::StatusOr<bool> ResumeBuffer::Take(Request* request) {
  if (!shares_memory_ && !request->released.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("released_batches has ", request->released.size(),
                     " entries, allowed: none, as pool ", pool_name_, " shares no memory"));
  }
  const int64_t number = request->sequence_number;
  absl::MutexLock lock(&mutex_);
  const int64_t forgotten =
      std::max(request->acknowledged, number - stream_.requests_in_flight_max);
  const SlotTable::Change change = {request->released, forgotten};
  if (shares_memory_ && request->kind == Request::Kind::kSample) {
    if (absl::Status status = slots_.Apply(change); !status.ok()) {
      return status;
    }
  } else if (shares_memory_) {
    const absl::StatusOr<int32_t> batch = slots_.Take(change, number, stream_.resumable);
    if (!batch.ok()) {
      return batch.status();
    }
    request->shared_batch = *batch;
  }
  kept_.ForgetUpTo(forgotten);
  TrimReservation();
  return stream_.resumable;
}

absl::StatusOr<Answer> ResumeBuffer::Recall(const Request& request, int64_t next_sequence_number) {
  absl::MutexLock lock(&mutex_);
  const Answer* answer = kept_.Find(request.sequence_number);
  if (answer == nullptr) {
    return absl::FailedPreconditionError(
        absl::StrCat("sequence_number is ", request.sequence_number, ", which pool ", pool_name_,
                     " has carried out before and whose answer is not kept; kept: ", kept_.Range(),
                     ", the next: ", next_sequence_number));
  }
  Answer recalled = *answer;
  slots_.HoldAgain(request.sequence_number);
  slots_.ForgetUpTo(request.acknowledged);
  kept_.ForgetUpTo(request.acknowledged);
  TrimReservation();
  return recalled;
}

void ResumeBuffer::Keep(int64_t sequence_number, Answer answer) {
  absl::MutexLock lock(&mutex_);
  kept_.Keep(sequence_number, std::move(answer));
}

int64_t ResumeBuffer::OldestOr(int64_t none) const {
  absl::MutexLock lock(&mutex_);
  return kept_.OldestOr(none);
}

}  // namespace procgen
