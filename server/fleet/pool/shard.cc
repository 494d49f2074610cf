#include "server/fleet/pool/shard.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/concurrency/start_thread.h"
#include "server/fleet/nodes/node_answers.h"
#include "server/fleet/timing.h"
#include "server/logging/event_log.h"

namespace procgen {

absl::StatusOr<std::unique_ptr<Shard>> Shard::Create(
    std::shared_ptr<const ShardContext> context, int32_t number, Part range,
    std::shared_ptr<const ShardCheckpoint> checkpoint, std::string preferred_node,
    ShardThreadBudget::Reservation reservation) {
  std::unique_ptr<Shard> shard(new Shard(std::move(context), number, range, std::move(checkpoint),
                                         std::move(preferred_node), std::move(reservation)));
  absl::StatusOr<std::thread> thread =
      StartThread([shard = shard.get()] { shard->RunUntilStopped(); });
  if (!thread.ok()) {
    return thread.status();
  }
  shard->thread_ = *std::move(thread);
  return shard;
}

Shard::Shard(std::shared_ptr<const ShardContext> context, int32_t number, Part range,
             std::shared_ptr<const ShardCheckpoint> checkpoint, std::string preferred_node,
             ShardThreadBudget::Reservation reservation)
    : context_(std::move(context)),
      number_(number),
      range_(range),
      reservation_(std::move(reservation)),
      preferred_node_(std::move(preferred_node)),
      checkpointer_(*context_, range, std::move(checkpoint)),
      executed_position_(checkpointer_.checkpoint_number()) {}

Shard::~Shard() {
  if (!thread_.joinable()) {
    return;  // it was not created
  }
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
    if (stream_ != nullptr) {
      stream_->Cancel();
    }
  }
  context_->nodes->OnNodesChanged();  // its thread may wait for a node
  thread_.join();
}

std::string Shard::node_id() const {
  absl::MutexLock lock(&mutex_);
  return node_id_;
}

bool Shard::Stops() const {
  absl::MutexLock lock(&mutex_);
  return stops_;
}

void Shard::Run(int64_t number, Done done) { Start({number, nullptr, std::move(done)}); }

void Shard::Save(std::vector<int32_t> environments, std::vector<std::string>* snapshots,
                 Done done) {
  const auto save = [environments = std::move(environments),
                     snapshots](const RemotePool& remote) -> absl::Status {
    absl::StatusOr<std::vector<std::string>> states = remote.SaveStates(environments);
    if (!states.ok()) {
      return states.status();
    }
    *snapshots = *std::move(states);
    return absl::OkStatus();
  };
  Start({std::nullopt, save, std::move(done)});
}

void Shard::Render(std::vector<int32_t> environments, View view, int32_t size_px,
                   std::vector<absl::Span<uint8_t>> frames, Done done) {
  const auto render = [environments = std::move(environments), view, size_px,
                       frames = std::move(frames)](const RemotePool& remote) {
    return remote.Render(environments, view, size_px, frames);
  };
  Start({std::nullopt, render, std::move(done)});
}

void Shard::Start(Task task) {
  absl::MutexLock lock(&mutex_);
  task_ = std::move(task);
}

void Shard::Rollback(int64_t number) {
  absl::MutexLock lock(&mutex_);
  rollback_number_ = number;
}

void Shard::OnNodesChanged() {
  std::shared_ptr<procgen_client::StepStream> stream;
  std::string node_id;
  {
    absl::MutexLock lock(&mutex_);
    nodes_changed_ = true;
    stream = stream_;
    node_id = node_id_;
  }
  if (stream != nullptr && !context_->nodes->IsPresent(node_id)) {
    stream->Cancel();  // it would wait for an answer in vain
  }
}

void Shard::RunUntilStopped() {
  const auto awaited = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stops_ || nodes_changed_ || rollback_number_.has_value() || task_.has_value();
  };
  while (true) {
    std::optional<Task> task;
    std::optional<int64_t> rollback_number;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(&awaited));
      if (stops_) {
        break;
      }
      nodes_changed_ = false;
      rollback_number = std::exchange(rollback_number_, std::nullopt);
      task = std::exchange(task_, std::nullopt);
    }
    if (rollback_number.has_value()) {
      RollbackNow(*rollback_number);
    }
    if (!task.has_value()) {
      Reconcile();
      continue;
    }
    absl::Status status = Execute(&*task);
    const bool may_save = status.ok();
    task->done(std::move(status));
    task.reset();
    if (may_save && remote_ != nullptr) {
      if (absl::Status saved = checkpointer_.SaveIfDue(*remote_); !saved.ok()) {
        MarkNodeFailed(saved);
      }
    }
  }
  SetWaits(false);
  Detach();
}

void Shard::RollbackNow(int64_t number) {
  if (remote_ != nullptr && remote_->position() > number) {
    Detach();
  }
  executed_position_ = std::min(executed_position_, number);
  checkpointer_.DiscardNext();
}

void Shard::Reconcile() {
  if (remote_ != nullptr) {
    if (context_->nodes->IsUsable(remote_->node_id())) {
      return;
    }
    MarkNodeFailed(absl::UnavailableError("the node drains or is gone"));
  }
  if (gives_up_) {
    return;
  }
  if (const absl::Status status = AdvanceTo(executed_position_); !status.ok()) {
    gives_up_ = !IsNodeError(status);
    MarkNodeFailed(status);
  }
}

absl::Status Shard::Execute(Task* task) {
  const absl::Time deadline = task->begin_time + context_->options->failover_timeout;
  const int64_t number = task->number.value_or(executed_position_);
  checkpointer_.Promote(number);
  bool failed_over = false;
  gives_up_ = false;
  int attempts = 0;
  while (true) {
    const bool was_placed = remote_ != nullptr;
    absl::Status status = AdvanceTo(number);
    if (status.ok() && task->work != nullptr) {
      status = task->work(*remote_);
    }
    if (status.ok()) {
      break;
    }
    MarkNodeFailed(status);
    failed_over = true;
    // A new pool does not wait for nodes that reject the server.
    const bool is_refused = number == 0 && absl::IsPermissionDenied(status);
    attempts += IsNodeError(status) && !is_refused ? 0 : 1;
    gives_up_ = attempts == kShardAttemptsMax;
    if (Stops() || gives_up_) {
      return status;
    }
    if (SteadyNow() >= deadline) {
      return TimeoutError(status);
    }
    if (!was_placed) {
      context_->nodes->AwaitChange(std::min(deadline, SteadyNow() + kShardPlaceRetry));
    }
  }
  if (failed_over && executed_position_ > 0) {
    LogResumed(SteadyNow() - task->begin_time);
  }
  executed_position_ = number;
  return absl::OkStatus();
}

absl::Status Shard::TimeoutError(const absl::Status& last) const {
  return absl::DeadlineExceededError(absl::StrCat(
      "environments ", RangeText(range_), " of ", context_->label, " have had no node for ",
      absl::FormatDuration(context_->options->failover_timeout),
      ", limit fleet_failover_timeout; the last error: ", last.message()));
}

void Shard::LogResumed(absl::Duration failover_time) const {
  context_->metrics->AddFleetFailover(failover_time);
  LogEvent(LogLevel::kInfo, "shard_resumed",
           {{"pool", context_->label},
            {"environments", RangeText(range_)},
            {"node", remote_->node_id()},
            {"failover_time", absl::FormatDuration(failover_time)}});
}

absl::Status Shard::AdvanceTo(int64_t number) {
  if (remote_ == nullptr) {
    if (absl::Status status = Place(); !status.ok()) {
      return status;
    }
  }
  return remote_->AdvanceTo(number, executed_position_, &answer_);
}

absl::Status Shard::Place() {
  absl::StatusOr<FleetNodes::CapacityReservation> capacity =
      context_->nodes->Reserve(range_.count, preferred_node_);
  if (!capacity.ok()) {
    return capacity.status();
  }
  const std::string node_id = capacity->node_id();
  absl::StatusOr<std::shared_ptr<NodeClient>> node = context_->nodes->Connect(node_id);
  if (!node.ok()) {
    context_->nodes->Suspect(node_id);
    return node.status();
  }
  const ShardCheckpoint& checkpoint = *checkpointer_.checkpoint();
  auto remote = RemotePool::Create(*context_, range_, checkpoint,
                                   absl::StrCat(context_->id_prefix, number_, "-", ++epoch_),
                                   *std::move(capacity), *std::move(node));
  if (!remote.ok()) {
    return remote.status();
  }
  LogEvent(LogLevel::kInfo, "shard_placed",
           {{"pool", context_->label},
            {"environments", RangeText(range_)},
            {"node", node_id},
            {"shard", (*remote)->name()},
            {"from", absl::StrCat(checkpoint.number)}});
  remote_ = *std::move(remote);
  preferred_node_ = node_id;
  {
    absl::MutexLock lock(&mutex_);
    node_id_ = node_id;
    stream_ = remote_->stream();
  }
  SetWaits(false);
  return absl::OkStatus();
}

void Shard::SetWaits(bool waits, const absl::Status& why) {
  if (waits == waits_) {
    return;
  }
  waits_ = waits;
  context_->metrics->AddFleetWaits(waits ? 1 : -1);
  if (waits) {
    LogEvent(LogLevel::kWarning, "shard_waiting",
             {{"pool", context_->label},
              {"environments", RangeText(range_)},
              {"message", std::string(why.message())}});
  }
}

void Shard::MarkNodeFailed(const absl::Status& why) {
  if (remote_ == nullptr) {
    SetWaits(true, why);
    return;
  }
  context_->metrics->AddFleetShardMigration();
  LogEvent(LogLevel::kWarning, "shard_lost",
           {{"pool", context_->label},
            {"environments", RangeText(range_)},
            {"node", remote_->node_id()},
            {"code", absl::StatusCodeToString(why.code())},
            {"message", std::string(why.message())}});
  context_->nodes->Suspect(remote_->node_id());
  Detach();
}

void Shard::Detach() {
  {
    absl::MutexLock lock(&mutex_);
    node_id_.clear();
    stream_ = nullptr;
  }
  remote_.reset();
}

}  // namespace procgen
