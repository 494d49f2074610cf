// What a stream does with a request that it has read.
#include <cstdint>
#include <memory>
#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/convert_pool.h"
#include "server/rpc/step_pool_reactor.h"

namespace procgen {

// NOLINTBEGIN(misc-no-recursion): as in Drive.
void StepPoolReactor::TakeIn(StreamRequest* request, absl::Status status) {
  if (status.ok()) {
    status = HoldLarge(request);
  }
  if (status.ok()) {
    status = Understand(request);
  }
  if (!status.ok()) {
    EndAfterInbox(std::move(status));
  }
  {
    absl::MutexLock lock(&mutex_);
    requests_.TakeIn(request);
  }
  Drive();
}
// NOLINTEND(misc-no-recursion)

absl::Status StepPoolReactor::HoldLarge(StreamRequest* request) const {
  if (request->message_bytes <= kLargeMessageBytes) {
    return absl::OkStatus();
  }
  absl::StatusOr<Owners::Share> share =
      callers_->HoldBytes(caller_.owner, static_cast<int64_t>(request->message.SpaceUsedLong()));
  if (share.ok()) {
    request->share = *std::move(share);
  }
  return share.status();
}

absl::Status StepPoolReactor::Understand(StreamRequest* request) const {
  if (absl::Status status = ReadStreamRequest(request); !status.ok()) {
    return status;
  }
  if (std::shared_ptr<const LevelSampler>& sampler = request->request.level_sampler;
      sampler != nullptr) {
    auto held = HoldSampler(caller_.owner, std::move(sampler), &sessions_->owners());
    if (!held.ok()) {
      return held.status();
    }
    sampler = *std::move(held);
  }
  if (pool_->shared_ring() != nullptr) {
    request->rows_max = INT32_MAX;  // its response bears none
    request->response_count_min = 1;
    return absl::OkStatus();
  }
  const absl::StatusOr<int32_t> rows_max = ResponseRowsMax(
      "attach.response_bytes_max", *request, pool_->coding(), terms_.response_bytes_max);
  request->rows_max = rows_max.value_or(0);
  return rows_max.status();
}

}  // namespace procgen
