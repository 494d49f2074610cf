// What a PoolSession does with shared memory.

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/session/pool_session.h"

namespace procgen {

absl::Status PoolSession::CheckHeldBatches(const AttachOptions& options) const {
  if (shared_ring_ == nullptr && (options.held_batches_max != 0 || !options.held_batches.empty())) {
    return absl::InvalidArgumentError(
        absl::StrCat("attach.held_batches_max is ", options.held_batches_max,
                     " and attach.held_batches has ", options.held_batches.size(),
                     " entries, allowed: none, as pool ", name_, " shares no memory"));
  }
  return batches_.CheckHeld(options.held_batches);
}

void PoolSession::ShareMemory(const AttachOptions& options, Done done) {
  if (shared_ring_ == nullptr) {
    done(absl::OkStatus());
    return;
  }
  const int32_t held_max =
      options.held_batches_max == 0 ? kHeldBatchesDefault : options.held_batches_max;
  surroundings_.executor->Run(owner_,
                              [this, batch_count = options.requests_in_flight_max + held_max,
                               done = std::move(done)]() mutable {
                                absl::Status status = GrowSharedRing(batch_count);
                                done(std::move(status));
                              });
}

absl::Status PoolSession::GrowSharedRing(int32_t batch_count) {
  const int64_t before = shared_ring_->size_bytes();
  const int64_t after = std::max(before, batch_count * shared_ring_->layout().batch_bytes());
  ByteBudget* budget = surroundings_.shared_memory_bytes;
  if (!budget->Change(before, after)) {
    return absl::ResourceExhaustedError(
        absl::StrCat("pool ", name_, " shares ", batch_count, " batches of ",
                     shared_ring_->layout().batch_bytes(), " bytes, and other pools ",
                     budget->reserved_bytes() - before, " bytes, limit shared_memory_bytes_max is ",
                     budget->bytes_max()));
  }
  if (absl::Status status = shared_ring_->Grow(batch_count); !status.ok()) {
    budget->Change(after, before);
    return status;
  }
  absl::MutexLock lock(&mutex_);
  batches_.Grow(batch_count);
  return absl::OkStatus();
}

absl::Status PoolSession::Take(Request* request) {
  const int64_t number = request->sequence_number;
  const int64_t forgotten =
      std::max(request->acknowledged, number - stream_options_.requests_in_flight_max);
  if (shared_ring_ == nullptr && !request->released.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("released_batches has ", request->released.size(),
                     " entries, allowed: none, as pool ", name_, " shares no memory"));
  }
  const BatchLedger::Change change = {request->released, forgotten};
  if (shared_ring_ != nullptr && request->kind == Request::Kind::kSample) {
    if (absl::Status status = batches_.Apply(change); !status.ok()) {
      return status;
    }
  } else if (shared_ring_ != nullptr) {
    const absl::StatusOr<int32_t> batch = batches_.Take(change, number, stream_options_.resumable);
    if (!batch.ok()) {
      return batch.status();
    }
    request->shared_batch = *batch;
  }
  kept_.ForgetUpTo(forgotten);
  TrimReservation();
  return absl::OkStatus();
}

}  // namespace procgen
