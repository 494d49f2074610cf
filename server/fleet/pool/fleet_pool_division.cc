// How a FleetPool is divided among nodes.

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/fleet/pool/countdown.h"
#include "server/fleet/pool/fleet_pool.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

// Another division is worth it where so large a part of the environments would move.
constexpr double kWorthMoving = 0.15;
constexpr int32_t kLooksBeforeDividing = 2;

// Shards of these shares, which all begin with `base`, that of the whole pool.
ShardBases BasesOf(const std::vector<FleetNodes::Share>& shares, const ShardBase& base) {
  ShardBases bases;
  Part range;
  for (const FleetNodes::Share& share : shares) {
    range = {range.first + range.count, share.env_count};
    ShardBase own = {base.number, {}, base.sampler};
    if (!base.states.empty()) {
      const auto first = base.states.begin() + range.first;
      own.states.assign(first, first + range.count);
    }
    bases[range.first] = {range, std::make_shared<const ShardBase>(std::move(own))};
  }
  return bases;
}

std::vector<std::string> NodesOf(const std::vector<FleetNodes::Share>& shares) {
  std::vector<std::string> nodes;
  nodes.reserve(shares.size());
  for (const FleetNodes::Share& share : shares) {
    nodes.push_back(share.node_id);
  }
  return nodes;
}

}  // namespace

void FleetPool::Begin(const std::vector<FleetNodes::Share>& shares, Done done) {
  auto made = MakeShards(BasesOf(shares, {0, {}, sampler_}), NodesOf(shares));
  if (!made.ok()) {
    done(made.status());
    return;
  }
  SetShards(*std::move(made));
  auto countdown = std::make_shared<Countdown>(shards_.size(), std::move(done));
  for (const std::unique_ptr<Shard>& shard : shards_) {
    shard->Run(0, [countdown](const absl::Status& status) { countdown->Count(status); });
  }
}

absl::StatusOr<std::vector<std::unique_ptr<Shard>>> FleetPool::MakeShards(
    const ShardBases& bases, const std::vector<std::string>& nodes) {
  std::vector<std::unique_ptr<Shard>> shards;
  for (const auto& [first, base] : bases) {
    const std::string node = nodes.empty() ? "" : nodes[shards.size()];
    auto shard = Shard::Create(terms_, ++shard_number_, base.first, base.second, node);
    if (!shard.ok()) {
      return shard.status();
    }
    shards.push_back(*std::move(shard));
  }
  return shards;
}

void FleetPool::SetShards(std::vector<std::unique_ptr<Shard>> shards) {
  absl::MutexLock lock(&shards_mutex_);
  shards_.swap(shards);  // those that were there end after the lock
  // What was seen of others says nothing of these.
  looks_worth_dividing_ = 0;
  divides_ = false;
}

void FleetPool::Look() {
  absl::MutexLock lock(&shards_mutex_);
  if (shards_.empty()) {
    return;  // it is being divided
  }
  std::vector<FleetNodes::Share> now;
  for (const std::unique_ptr<Shard>& shard : shards_) {
    shard->Look();
    now.push_back({shard->node_id(), shard->range().count});
  }
  // What nodes tell of themselves may be old, so a single look is not enough.
  looks_worth_dividing_ = IsWorthDividing(now) ? looks_worth_dividing_ + 1 : 0;
  if (looks_worth_dividing_ >= kLooksBeforeDividing) {
    looks_worth_dividing_ = 0;
    divides_ = true;
  }
}

bool FleetPool::IsWorthDividing(const std::vector<FleetNodes::Share>& now) const {
  std::map<std::string, int32_t> counts;
  for (const FleetNodes::Share& share : now) {
    if (!terms_->nodes->IsUsable(share.node_id)) {
      return false;  // a shard is on its way
    }
    counts[share.node_id] += share.env_count;
  }
  const auto better = terms_->nodes->DivideAgain(env_count(), now);
  if (!better.ok()) {
    return false;
  }
  int32_t moving = 0;
  for (const FleetNodes::Share& share : *better) {
    moving += std::max(0, share.env_count - counts[share.node_id]);
  }
  return moving >= kWorthMoving * env_count();
}

void FleetPool::BeginDivision(int64_t number) {
  std::vector<int32_t> all(static_cast<size_t>(env_count()));
  std::iota(all.begin(), all.end(), 0);
  Gather(all, [this, number](absl::StatusOr<std::vector<std::string>> states) {
    // Not on the thread of a shard, which may have to go.
    executor_->Run(terms_->owner, [this, number, states = std::move(states)]() mutable {
      if (states.ok()) {
        division_ = SavedBase{
            std::make_shared<const ShardBase>(ShardBase{number - 1, *std::move(states), sampler_})};
      }
      if (CanDivide(number)) {
        Divide(*division_->base);
        division_.reset();
      }
      RunRequest(number);
    });
  });
}

bool FleetPool::CanDivide(int64_t number) {
  if (!division_.has_value()) {
    return false;
  }
  if (division_->IsUsable(log_, {0, env_count()}, number, terms_->answers_kept)) {
    return true;
  }
  if (number > division_->base->number + 2 * terms_->options->snapshot_requests) {
    division_.reset();  // or else the log would have to reach back to it for good
  }
  return false;
}

void FleetPool::Divide(const ShardBase& base) {
  std::vector<FleetNodes::Share> now;
  for (const std::unique_ptr<Shard>& shard : shards_) {
    now.push_back({shard->node_id(), shard->range().count});
  }
  const auto shares = terms_->nodes->DivideAgain(env_count(), now);
  if (!shares.ok()) {
    return;  // nodes have gone in the meantime
  }
  ShardBases bases = BasesOf(*shares, base);
  auto shards = MakeShards(bases, NodesOf(*shares));
  if (!shards.ok()) {
    LogEvent(LogLevel::kWarning, "pool_rebalance_failed",
             {{"pool", terms_->label}, {"message", std::string(shards.status().message())}});
    return;
  }
  SetShards({});  // before the others go to nodes: they need the room
  LogEvent(LogLevel::kInfo, "pool_rebalanced",
           {{"pool", terms_->label},
            {"shards", absl::StrCat(shares->size())},
            {"from", absl::StrCat(base.number)}});
  SetShards(*std::move(shards));
  if (journal_ != nullptr) {
    journal_->SetBases(std::move(bases));
  }
}

}  // namespace procgen
