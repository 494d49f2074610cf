#include "server/fleet/pool/shard_set.h"

#include <algorithm>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/fleet/log/shard_request.h"
#include "server/fleet/pool/completion_latch.h"

namespace procgen {

ShardCheckpoints SplitCheckpoint(const ShardCheckpoint& checkpoint,
                                 const std::vector<ShardAssignment>& assignments) {
  ShardCheckpoints checkpoints;
  Part range;
  for (const ShardAssignment& assignment : assignments) {
    range = {range.first + range.count, assignment.env_count};
    ShardCheckpoint own = {checkpoint.number, {}, checkpoint.sampler};
    if (!checkpoint.states.empty()) {
      const auto first = checkpoint.states.begin() + range.first;
      own.states.assign(first, first + range.count);
    }
    checkpoints[range.first] = {range, std::make_shared<const ShardCheckpoint>(std::move(own))};
  }
  return checkpoints;
}

absl::StatusOr<ShardSet::Shards> ShardSet::Make(const ShardCheckpoints& checkpoints,
                                                const std::vector<ShardAssignment>& assignments) {
  auto threads = context_->threads->Reserve(checkpoints.size());
  if (!threads.ok()) {
    return threads.status();
  }
  if (threads->size() < checkpoints.size()) {
    return absl::ResourceExhaustedError(absl::StrCat(context_->label, " has ", checkpoints.size(),
                                                     " shards, and the fleet has threads left for ",
                                                     threads->size()));
  }
  return Make(checkpoints, assignments, *std::move(threads));
}

absl::StatusOr<ShardSet::Shards> ShardSet::Make(
    const ShardCheckpoints& checkpoints, const std::vector<ShardAssignment>& assignments,
    std::vector<ShardThreadBudget::Reservation> threads) {
  Shards shards;
  for (const auto& [first, checkpoint] : checkpoints) {
    const std::string node = assignments.empty() ? "" : assignments[shards.size()].node_id;
    auto shard = Shard::Create(context_, ++shard_number_, checkpoint.first, checkpoint.second, node,
                               std::move(threads[shards.size()]));
    if (!shard.ok()) {
      return shard.status();
    }
    shards.push_back(*std::move(shard));
  }
  return shards;
}

ShardSet::Shards ShardSet::Replace(Shards shards) {
  absl::MutexLock lock(&mutex_);
  shards_.swap(shards);
  return shards;
}

std::vector<ShardAssignment> ShardSet::assignments() const {
  std::vector<ShardAssignment> assignments;
  assignments.reserve(shards_.size());
  for (const std::unique_ptr<Shard>& shard : shards_) {
    assignments.push_back({shard->node_id(), shard->range().count});
  }
  return assignments;
}

ShardCheckpoints ShardSet::checkpoints() const {
  ShardCheckpoints checkpoints;
  for (const std::unique_ptr<Shard>& shard : shards_) {
    checkpoints[shard->range().first] = {shard->range(), shard->checkpoint()};
  }
  return checkpoints;
}

int64_t ShardSet::checkpoint_number() const {
  int64_t number = shards_.front()->checkpoint_number();
  for (const std::unique_ptr<Shard>& shard : shards_) {
    number = std::min(number, shard->checkpoint_number());
  }
  return number;
}

std::vector<Shard*> ShardSet::Overlapping(Part range) const {
  std::vector<Shard*> shards;
  for (const std::unique_ptr<Shard>& shard : shards_) {
    if (Overlap(range, shard->range()).count > 0) {
      shards.push_back(shard.get());
    }
  }
  return shards;
}

std::vector<Shard*> ShardSet::Containing(const std::vector<int32_t>& environments) const {
  std::set<size_t> indices;
  for (const int32_t environment : environments) {
    indices.insert(IndexOf(environment));
  }
  std::vector<Shard*> shards;
  shards.reserve(indices.size());
  for (const size_t index : indices) {
    shards.push_back(shards_[index].get());
  }
  return shards;
}

size_t ShardSet::IndexOf(int32_t environment) const {
  size_t index = 0;
  while (environment >= shards_[index]->range().first + shards_[index]->range().count) {
    ++index;
  }
  return index;
}

std::vector<ShardSet::Selection> ShardSet::Select(const std::vector<int32_t>& environments) const {
  std::vector<Selection> selections(shards_.size());
  for (size_t place = 0; place < environments.size(); ++place) {
    const size_t index = IndexOf(environments[place]);
    Selection& selection = selections[index];
    selection.shard = shards_[index].get();
    selection.environments.push_back(environments[place] - selection.shard->range().first);
    selection.places.push_back(place);
  }
  std::erase_if(selections, [](const Selection& each) { return each.shard == nullptr; });
  return selections;
}

void ShardSet::Run(const std::vector<Shard*>& shards, int64_t number, Done done) {
  auto latch = std::make_shared<CompletionLatch>(shards.size(), std::move(done));
  for (Shard* const shard : shards) {
    shard->Run(number, [latch](const absl::Status& status) { latch->CountDown(status); });
  }
}

void ShardSet::Rollback(int64_t number) {
  for (const std::unique_ptr<Shard>& shard : shards_) {
    shard->Rollback(number);
  }
}

void ShardSet::Save(const std::vector<int32_t>& environments, SaveDone done) {
  if (environments.empty()) {
    done(std::vector<std::string>());
    return;
  }
  struct Saved {
    std::vector<Selection> selections;
    std::vector<std::vector<std::string>> snapshots;  // of each selection
  };
  auto saved = std::make_shared<Saved>();
  saved->selections = Select(environments);
  saved->snapshots.resize(saved->selections.size());
  const auto finish = [saved, count = environments.size(),
                       done = std::move(done)](absl::Status status) {
    if (!status.ok()) {
      done(std::move(status));
      return;
    }
    std::vector<std::string> snapshots(count);
    for (size_t i = 0; i < saved->selections.size(); ++i) {
      const std::vector<size_t>& places = saved->selections[i].places;
      for (size_t j = 0; j < places.size(); ++j) {
        snapshots[places[j]] = std::move(saved->snapshots[i][j]);
      }
    }
    done(std::move(snapshots));
  };
  auto latch = std::make_shared<CompletionLatch>(saved->selections.size(), finish);
  for (size_t i = 0; i < saved->selections.size(); ++i) {
    const Selection& selection = saved->selections[i];
    selection.shard->Save(selection.environments, &saved->snapshots[i],
                          [latch](const absl::Status& status) { latch->CountDown(status); });
  }
}

void ShardSet::Render(const std::vector<int32_t>& environments, View view, int32_t size_px,
                      const std::vector<absl::Span<uint8_t>>& frames, Done done) {
  const std::vector<Selection> selections = Select(environments);
  auto latch = std::make_shared<CompletionLatch>(selections.size(), std::move(done));
  for (const Selection& selection : selections) {
    std::vector<absl::Span<uint8_t>> own;
    own.reserve(selection.places.size());
    for (const size_t place : selection.places) {
      own.push_back(frames[place]);
    }
    selection.shard->Render(selection.environments, view, size_px, std::move(own),
                            [latch](const absl::Status& status) { latch->CountDown(status); });
  }
}

std::vector<ShardAssignment> ShardSet::OnNodesChanged() {
  absl::MutexLock lock(&mutex_);
  for (const std::unique_ptr<Shard>& shard : shards_) {
    shard->OnNodesChanged();
  }
  return assignments();
}

}  // namespace procgen
