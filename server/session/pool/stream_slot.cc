#include "server/session/pool/stream_slot.h"

#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"

namespace procgen {

StreamSlot::StreamSlot(Context context, absl::Duration lease_duration)
    : context_(std::move(context)), lease_duration_(lease_duration) {
  absl::MutexLock lock(&mutex_);
  BeginLease();
}

bool StreamSlot::attached() const {
  absl::MutexLock lock(&mutex_);
  return attached_;
}

bool StreamSlot::closed() const {
  absl::MutexLock lock(&mutex_);
  return !closed_.ok();
}

absl::Duration StreamSlot::lease_duration() const {
  absl::MutexLock lock(&mutex_);
  return lease_duration_;
}

absl::Time StreamSlot::expire_time() const {
  absl::MutexLock lock(&mutex_);
  return expire_time_;
}

void StreamSlot::Attach(const AttachOptions& options, EndStream end_stream, Done done) {
  absl::Status status;
  EndStream end_other;
  std::optional<Successor> replaced;
  {
    absl::MutexLock lock(&mutex_);
    status = CheckAttach(options);
    if (status.ok() && !attached_) {
      BeginStream(options, std::move(end_stream));
    } else if (status.ok()) {
      std::swap(replaced, successor_);
      std::swap(end_other, end_stream_);
      successor_ = Successor{options, std::move(end_stream), std::exchange(done, nullptr)};
      context_.resume_buffer->SetSuccessor(options);
    }
  }
  const absl::Status taken_over =
      absl::AbortedError(absl::StrCat("another stream took over pool ", context_.pool_name));
  if (done != nullptr) {
    done(std::move(status));
  }
  if (replaced.has_value()) {
    replaced->done(taken_over);
  }
  if (end_other != nullptr) {
    end_other(StreamEnd::kTakenOver, taken_over);
  }
}

absl::Status StreamSlot::CheckAttach(const AttachOptions& options) {
  if (!closed_.ok()) {
    return closed_;
  }
  if (attached_ && !options.take_over) {
    return absl::FailedPreconditionError(
        absl::StrCat("another stream is attached to pool ", context_.pool_name,
                     ", allowed: one at a time; ", options.when_attached));
  }
  Quotas::Reservation reservation;
  if (!attached_) {
    absl::StatusOr<Quotas::Reservation> taken =
        context_.quotas->Reserve(context_.owner, {.stream_count = 1});
    if (!taken.ok()) {
      return taken.status();
    }
    reservation = *std::move(taken);
  }
  if (absl::Status status = context_.resume_buffer->Reserve(options); !status.ok()) {
    return status;
  }
  if (!attached_) {
    stream_reservation_ = std::move(reservation);
  }
  return absl::OkStatus();
}

void StreamSlot::BeginStream(const AttachOptions& options, EndStream end_stream) {
  attached_ = true;
  end_stream_ = std::move(end_stream);
  expire_time_ = absl::InfiniteFuture();
  context_.resume_buffer->BeginStream(options, *context_.next_sequence_number);
}

void StreamSlot::Detach() {
  EndStream last;  // destroyed outside the lock; it may own the stream
  std::optional<Successor> next;
  {
    absl::MutexLock lock(&mutex_);
    std::swap(last, end_stream_);
    std::swap(next, successor_);
    if (next.has_value()) {
      BeginStream(next->options, std::move(next->end_stream));
    } else {
      attached_ = false;
      stream_reservation_ = Quotas::Reservation();
      BeginLease();
    }
  }
  if (next.has_value()) {
    next->done(absl::OkStatus());
  }
}

void StreamSlot::BeginLease() {
  expire_time_ = context_.lease_timer->Now() + lease_duration_;
  context_.lease_timer->ArmBy(expire_time_);
}

absl::Status StreamSlot::Renew(std::optional<absl::Duration> lease_duration) {
  absl::MutexLock lock(&mutex_);
  if (!closed_.ok()) {
    return closed_;
  }
  lease_duration_ = lease_duration.value_or(lease_duration_);
  if (!attached_) {
    BeginLease();
  }
  return absl::OkStatus();
}

void StreamSlot::End(StreamEnd why, const absl::Status& reason) {
  EndStream end_stream;
  {
    absl::MutexLock lock(&mutex_);
    std::swap(end_stream, end_stream_);
  }
  if (end_stream != nullptr) {
    end_stream(why, reason);
  }
}

void StreamSlot::Close(const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  closed_ = reason;
}

bool StreamSlot::CloseIfOpen(const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  if (!closed_.ok()) {
    return false;
  }
  closed_ = reason;
  return true;
}

bool StreamSlot::CloseIfExpired(absl::Time now, const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  if (expire_time_ > now) {
    return false;
  }
  closed_ = reason;
  return true;
}

void StreamSlot::EndAll(const absl::Status& reason) {
  std::optional<Successor> successor;
  {
    absl::MutexLock lock(&mutex_);
    successor.swap(successor_);
  }
  End(StreamEnd::kClosed, reason);
  if (successor.has_value()) {
    successor->done(reason);
  }
}

}  // namespace procgen
