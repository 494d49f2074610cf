#include "server/fleet/pool/checkpointer.h"

#include <string>
#include <utility>
#include <vector>

#include "server/fleet/nodes/node_answers.h"
#include "server/logging/event_log.h"

namespace procgen {

Checkpointer::Checkpointer(const ShardTerms& terms, Part range,
                           std::shared_ptr<const ShardBase> base)
    : terms_(terms), range_(range), base_(std::move(base)), base_number_(base_->number) {}

void Checkpointer::Promote(int64_t number) {
  if (!next_.has_value() ||
      !next_->IsUsable(terms_.log->requests(), range_, number, terms_.answers_kept)) {
    return;
  }
  base_ = std::move(next_->base);
  next_.reset();
  terms_.log->SetBase(range_, base_);
  base_number_ = base_->number;
}

bool Checkpointer::IsDue(int64_t position) const {
  if (next_.has_value() || position < retry_position_) {
    return false;
  }
  const FleetOptions& options = *terms_.options;
  return position - base_->number >= options.snapshot_requests ||
         (position > base_->number &&
          terms_.log->requests().BytesAfter(base_->number) >= options.snapshot_bytes);
}

absl::Status Checkpointer::SaveIfDue(const RemotePool& pool) {
  if (!IsDue(pool.position())) {
    return absl::OkStatus();
  }
  absl::StatusOr<std::vector<std::string>> states = pool.SaveStates({});
  if (states.ok()) {
    next_ = SavedBase{std::make_shared<const ShardBase>(
        ShardBase{pool.position(), *std::move(states), pool.sampler()})};
    return absl::OkStatus();
  }
  if (IsNodeError(states.status())) {
    return states.status();
  }
  retry_position_ = pool.position() + terms_.options->snapshot_requests / 4;
  LogEvent(LogLevel::kWarning, "checkpoint_failed",
           {{"pool", terms_.label},
            {"environments", RangeText(range_)},
            {"code", absl::StatusCodeToString(states.status().code())},
            {"message", std::string(states.status().message())}});
  return absl::OkStatus();
}

}  // namespace procgen
