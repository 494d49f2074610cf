#include "server/fleet/pool/checkpointer.h"

#include <string>
#include <utility>
#include <vector>

#include "server/fleet/nodes/node_answers.h"
#include "server/logging/event_log.h"

namespace procgen {

Checkpointer::Checkpointer(const ShardContext& context, Part range,
                           std::shared_ptr<const ShardCheckpoint> checkpoint)
    : context_(context),
      range_(range),
      checkpoint_(std::move(checkpoint)),
      checkpoint_number_(checkpoint_->number) {}

void Checkpointer::Promote(int64_t number) {
  if (!next_.has_value() ||
      !next_->IsUsable(context_.log->requests(), range_, number, context_.answers_kept)) {
    return;
  }
  checkpoint_ = std::move(next_->checkpoint);
  next_.reset();
  context_.log->SetCheckpoint(range_, checkpoint_);
  checkpoint_number_ = checkpoint_->number;
}

bool Checkpointer::IsDue(int64_t position) const {
  if (next_.has_value() || position < retry_position_) {
    return false;
  }
  const FleetOptions& options = *context_.options;
  return position - checkpoint_->number >= options.snapshot_requests ||
         (position > checkpoint_->number &&
          context_.log->requests().BytesAfter(checkpoint_->number) >= options.snapshot_bytes);
}

absl::Status Checkpointer::SaveIfDue(const RemotePool& pool) {
  if (!IsDue(pool.position())) {
    return absl::OkStatus();
  }
  absl::StatusOr<std::vector<std::string>> states = pool.SaveStates({});
  if (states.ok()) {
    next_ = PendingCheckpoint{std::make_shared<const ShardCheckpoint>(
        ShardCheckpoint{pool.position(), *std::move(states), pool.sampler()})};
    return absl::OkStatus();
  }
  if (IsNodeError(states.status())) {
    return states.status();
  }
  retry_position_ = pool.position() + context_.options->snapshot_requests / 4;
  LogEvent(LogLevel::kWarning, "checkpoint_failed",
           {{"pool", context_.label},
            {"environments", RangeText(range_)},
            {"code", absl::StatusCodeToString(states.status().code())},
            {"message", std::string(states.status().message())}});
  return absl::OkStatus();
}

}  // namespace procgen
