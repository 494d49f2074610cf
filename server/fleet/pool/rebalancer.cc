#include "server/fleet/pool/rebalancer.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

// Minimum fraction of environments that must move for a rebalance.
constexpr double kMovedFractionMin = 0.15;
// Nodes' reports may be stale, so one result is not enough.
constexpr int32_t kWorthItCountMin = 2;

}  // namespace

Rebalancer::Rebalancer(std::shared_ptr<const ShardContext> context, int32_t env_count,
                       ShardSet* shards, BackgroundExecutor* executor)
    : context_(std::move(context)), env_count_(env_count), shards_(shards), executor_(executor) {}

void Rebalancer::OnNodesChanged() {
  absl::MutexLock lock(&mutex_);
  const std::vector<ShardAssignment> assignments = shards_->OnNodesChanged();
  worth_it_count_ = IsWorthIt(assignments) ? worth_it_count_ + 1 : 0;
  if (worth_it_count_ >= kWorthItCountMin) {
    worth_it_count_ = 0;
    is_due_ = true;
  }
}

bool Rebalancer::IsWorthIt(const std::vector<ShardAssignment>& assignments) const {
  std::map<std::string, int32_t> counts;
  for (const ShardAssignment& assignment : assignments) {
    if (!context_->nodes->IsUsable(assignment.node_id)) {
      return false;  // the shard is about to move
    }
    counts[assignment.node_id] += assignment.env_count;
  }
  if (counts.empty()) {
    return false;  // the shards are being replaced
  }
  const auto better = context_->nodes->PlanRebalance(env_count_, assignments);
  // The new shards start before the old ones end.
  if (!better.ok() || better->size() > context_->threads->available()) {
    return false;
  }
  int32_t moved_count = 0;
  for (const ShardAssignment& assignment : *better) {
    moved_count += std::max(0, assignment.env_count - counts[assignment.node_id]);
  }
  return moved_count >= kMovedFractionMin * env_count_;
}

void Rebalancer::BeforeRequest(int64_t number, std::shared_ptr<const v1::LevelSampler> sampler,
                               absl::AnyInvocable<void()> run) {
  if (is_due_.exchange(false) && !pending_.has_value()) {
    std::vector<int32_t> all(static_cast<size_t>(env_count_));
    std::iota(all.begin(), all.end(), 0);
    auto shared_run = std::make_shared<absl::AnyInvocable<void()>>(std::move(run));
    shards_->Save(all, [this, number, sampler = std::move(sampler), run = std::move(shared_run)](
                           absl::StatusOr<std::vector<std::string>> states) {
      // Not on a shard's thread, since that shard may be destroyed.
      executor_->Run(context_->owner,
                     [this, number, sampler, run, states = std::move(states)]() mutable {
                       if (states.ok()) {
                         pending_ = PendingCheckpoint{std::make_shared<const ShardCheckpoint>(
                             ShardCheckpoint{number - 1, *std::move(states), std::move(sampler)})};
                       }
                       if (CanRebalance(number)) {
                         Rebalance();
                       }
                       (*run)();
                     });
    });
  } else if (CanRebalance(number)) {
    executor_->Run(context_->owner, [this, run = std::move(run)]() mutable {
      Rebalance();
      run();
    });
  } else {
    run();
  }
}

bool Rebalancer::CanRebalance(int64_t number) {
  if (!pending_.has_value()) {
    return false;
  }
  if (pending_->IsUsable(context_->log->requests(), {0, env_count_}, number,
                         context_->answers_kept)) {
    return true;
  }
  if (number > pending_->checkpoint->number + 2 * context_->options->snapshot_requests) {
    pending_.reset();  // otherwise the log would have to reach back to it indefinitely
  }
  return false;
}

void Rebalancer::Rebalance() {
  const PendingCheckpoint pending = *std::exchange(pending_, std::nullopt);
  const auto assignments = context_->nodes->PlanRebalance(env_count_, shards_->assignments());
  if (!assignments.ok()) {
    return;  // nodes have gone meanwhile
  }
  auto shards = shards_->Make(SplitCheckpoint(*pending.checkpoint, *assignments), *assignments);
  if (!shards.ok()) {
    LogEvent(LogLevel::kWarning, "pool_rebalance_failed",
             {{"pool", context_->label}, {"message", std::string(shards.status().message())}});
    return;
  }
  ReplaceShards({});  // first, since the new shards need the capacity
  LogEvent(LogLevel::kInfo, "pool_rebalanced",
           {{"pool", context_->label},
            {"shards", absl::StrCat(assignments->size())},
            {"from", absl::StrCat(pending.checkpoint->number)}});
  ReplaceShards(*std::move(shards));
  context_->log->SetCheckpoints(shards_->checkpoints());
}

void Rebalancer::ReplaceShards(ShardSet::Shards shards) {
  ShardSet::Shards replaced;  // destroyed after the lock is released
  absl::MutexLock lock(&mutex_);
  replaced = shards_->Replace(std::move(shards));
  worth_it_count_ = 0;
  is_due_ = false;
}

int64_t Rebalancer::checkpoint_number() const {
  return pending_.has_value() ? pending_->checkpoint->number : INT64_MAX;
}

}  // namespace procgen
