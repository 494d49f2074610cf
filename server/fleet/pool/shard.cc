#include "server/fleet/pool/shard.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/concurrency/start_thread.h"
#include "server/fleet/log/shard_request.h"
#include "server/fleet/nodes/node_answers.h"
#include "server/fleet/timing.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

// Whether an error may be of the node, so that another may do better; otherwise it would come
// again.
bool IsOfNode(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnimplemented:
      return false;
    default:
      return true;
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<Shard>> Shard::Create(std::shared_ptr<const ShardTerms> terms,
                                                     int32_t number, Part range,
                                                     std::shared_ptr<const ShardBase> base,
                                                     std::string preferred_node) {
  std::unique_ptr<Shard> shard(
      new Shard(std::move(terms), number, range, std::move(base), std::move(preferred_node)));
  absl::StatusOr<std::thread> thread = StartThread([shard = shard.get()] { shard->Loop(); });
  if (!thread.ok()) {
    return thread.status();
  }
  shard->thread_ = *std::move(thread);
  return shard;
}

Shard::Shard(std::shared_ptr<const ShardTerms> terms, int32_t number, Part range,
             std::shared_ptr<const ShardBase> base, std::string preferred_node)
    : terms_(std::move(terms)),
      number_(number),
      range_(range),
      preferred_node_(std::move(preferred_node)),
      base_(std::move(base)),
      asked_position_(base_->number),
      base_number_(base_->number) {}

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
  terms_->nodes->OnChange();  // it may wait for one
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

std::string Shard::Environments() const {
  return absl::StrCat(range_.first, " to ", range_.first + range_.count - 1);
}

void Shard::Run(int64_t number, Done done) { Start({number, nullptr, std::move(done)}); }

void Shard::Save(std::vector<int32_t> environments, std::vector<std::string>* snapshots,
                 Done done) {
  const auto save = [this, environments = std::move(environments), snapshots]() -> absl::Status {
    absl::StatusOr<std::vector<std::string>> states = FetchStates(environments);
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
  const auto render = [this, environments = std::move(environments), view, size_px,
                       frames = std::move(frames)]() -> absl::Status {
    for (size_t i = 0; i < environments.size(); ++i) {
      const auto rendered = placement_->node->client->RenderEnvironments(
          placement_->pool, {&environments[i], 1}, size_px, v1::FRAME_FORMAT_RGB,
          view == View::kAgent ? v1::FRAME_VIEW_AGENT : v1::FRAME_VIEW_HUMAN);
      if (!rendered.ok()) {
        return rendered.status();
      }
      if (absl::Status status = CheckNodeFrame(*rendered, frames[i].size()); !status.ok()) {
        return Distrust(status);
      }
      const std::string& image = rendered->frames(0).image();
      std::memcpy(frames[i].data(), image.data(), image.size());
    }
    return absl::OkStatus();
  };
  Start({std::nullopt, render, std::move(done)});
}

void Shard::Start(Task task) {
  absl::MutexLock lock(&mutex_);
  task_ = std::move(task);
}

void Shard::Forget(int64_t number) {
  absl::MutexLock lock(&mutex_);
  forgets_ = number;
}

void Shard::Look() {
  std::shared_ptr<procgen_client::StepStream> stream;
  std::string node_id;
  {
    absl::MutexLock lock(&mutex_);
    looks_ = true;
    stream = stream_;
    node_id = node_id_;
  }
  if (stream != nullptr && !terms_->nodes->IsPresent(node_id)) {
    stream->Cancel();  // whoever waits for its answer would wait in vain
  }
}

void Shard::Loop() {
  const auto awaited = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stops_ || looks_ || forgets_.has_value() || task_.has_value();
  };
  while (true) {
    std::optional<Task> task;
    std::optional<int64_t> forgets;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(&awaited));
      if (stops_) {
        break;
      }
      looks_ = false;
      forgets = std::exchange(forgets_, std::nullopt);
      task = std::exchange(task_, std::nullopt);
    }
    if (forgets.has_value()) {
      GoBack(*forgets);
    }
    if (!task.has_value()) {
      Settle();
      continue;
    }
    absl::Status status = Do(&*task);
    const bool goes_on = status.ok();
    task->done(std::move(status));
    task.reset();
    if (goes_on) {
      SaveBase();
    }
  }
  SetWaits(false);
  Leave();
}

void Shard::GoBack(int64_t number) {
  if (position_ > number) {
    Leave();
  }
  asked_position_ = std::min(asked_position_, number);
  next_base_.reset();  // what made it usable may be among what is taken back
}

void Shard::Settle() {
  if (placement_.has_value()) {
    if (terms_->nodes->IsUsable(placement_->node->node_id)) {
      return;
    }
    Lose(absl::UnavailableError("the node drains or is gone"));
  }
  if (gives_up_) {
    return;
  }
  if (const absl::Status status = Reach(asked_position_); !status.ok()) {
    gives_up_ = !IsOfNode(status);
    Lose(status);
  }
}

absl::Status Shard::Do(Task* task) {
  const absl::Time deadline = task->begin_time + terms_->options->failover_timeout;
  const int64_t number = task->number.value_or(asked_position_);
  PromoteBase(number);
  bool failed_over = false;
  gives_up_ = false;
  int attempts = 0;
  while (true) {
    const bool was_placed = placement_.has_value();
    absl::Status status = Reach(number);
    if (status.ok() && task->work != nullptr) {
      status = task->work();
    }
    if (status.ok()) {
      break;
    }
    Lose(status);
    failed_over = true;
    // A pool that is being made need not wait for nodes that let nobody in.
    const bool is_refused = number == 0 && absl::IsPermissionDenied(status);
    attempts += IsOfNode(status) && !is_refused ? 0 : 1;
    gives_up_ = attempts == kShardAttemptsMax;
    if (Stops() || gives_up_) {
      return status;
    }
    if (SteadyNow() >= deadline) {
      return TimeIsUp(status);
    }
    if (!was_placed) {
      terms_->nodes->AwaitChange(std::min(deadline, SteadyNow() + kShardPlaceRetry));
    }
  }
  if (failed_over && asked_position_ > 0) {
    const absl::Duration failover_time = SteadyNow() - task->begin_time;
    terms_->metrics->AddFleetFailover(failover_time);
    LogEvent(LogLevel::kInfo, "shard_resumed",
             {{"pool", terms_->label},
              {"environments", Environments()},
              {"node", placement_->node->node_id},
              {"failover_time", absl::FormatDuration(failover_time)}});
  }
  asked_position_ = number;
  return absl::OkStatus();
}

absl::Status Shard::TimeIsUp(const absl::Status& last) const {
  return absl::DeadlineExceededError(
      absl::StrCat("environments ", Environments(), " of ", terms_->label, " have had no node for ",
                   absl::FormatDuration(terms_->options->failover_timeout),
                   ", limit fleet_failover_timeout; the last error: ", last.message()));
}

absl::Status Shard::Reach(int64_t number) {
  if (!placement_.has_value()) {
    if (absl::Status status = Place(); !status.ok()) {
      return status;
    }
  }
  while (position_ < number) {
    const RequestLog::Entry logged = terms_->log->Find(position_ + 1);
    const bool is_asked_for = position_ + 1 == number && number > asked_position_;
    absl::Status status = is_asked_for ? CarryOut(*logged) : Repeat(*logged);
    if (!status.ok()) {
      return status;
    }
    ++position_;
    if (logged->request.has_level_sampler()) {
      sampler_ = {logged, &logged->request.level_sampler()};
    }
  }
  return ReceiveAll();
}

absl::Status Shard::Repeat(const LoggedRequest& logged) {
  if (!logged.states.empty()) {
    return PutStates(logged);
  }
  std::optional<v1::StepPoolRequest> request = CutRequest(logged.request, range_);
  if (!request.has_value() || request->has_observe()) {
    return absl::OkStatus();
  }
  AskForNoPictures(&*request);
  procgen_client::StepStream* const stream = placement_->stream.get();
  if (unanswered_ == stream->requests_in_flight_max()) {
    if (absl::Status status = stream->Receive(&repeated_); !status.ok()) {
      return StreamError(std::move(status));
    }
    --unanswered_;
  }
  ++unanswered_;
  return StreamError(stream->Send(*std::move(request)).status());
}

absl::Status Shard::CarryOut(const LoggedRequest& logged) {
  if (!logged.states.empty()) {
    return PutStates(logged);
  }
  std::optional<v1::StepPoolRequest> request = CutRequest(logged.request, range_);
  absl::Status status = ReceiveAll();
  if (!status.ok() || !request.has_value()) {
    return status;
  }
  procgen_client::StepStream* const stream = placement_->stream.get();
  if (request->has_step()) {
    request->mutable_step()->set_chunk_count(stream->chunk_count());
  }
  const bool has_rows = !request->has_level_sampler();
  const AskedRows asked = AskedRowsOf(*request);
  status = StreamError(stream->Call(*std::move(request), &answer_));
  if (status.ok() && has_rows) {
    status = CheckNodeBatch(answer_, asked, terms_->observation_bytes);
    return status.ok() ? status : Distrust(status);
  }
  return status;
}

absl::Status Shard::PutStates(const LoggedRequest& logged) {
  if (absl::Status status = ReceiveAll(); !status.ok()) {
    return status;
  }
  std::vector<v1::State> states;
  for (const v1::State& state : logged.states) {
    if (state.environment() >= range_.first && state.environment() < range_.first + range_.count) {
      states.push_back(state);
      states.back().set_environment(state.environment() - range_.first);
    }
  }
  return states.empty() ? absl::OkStatus()
                        : placement_->node->client->RestoreStates(placement_->pool, states);
}

absl::Status Shard::ReceiveAll() {
  for (; unanswered_ > 0; --unanswered_) {
    if (absl::Status status = placement_->stream->Receive(&repeated_); !status.ok()) {
      return StreamError(std::move(status));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> Shard::FetchStates(
    absl::Span<const int32_t> environments) const {
  auto states = placement_->node->client->SaveStates(placement_->pool, environments,
                                                     placement_->node->limits.response_bytes_max());
  if (!states.ok()) {
    return states.status();
  }
  auto snapshots = TakeNodeStates(*std::move(states), environments, range_.count);
  if (!snapshots.ok()) {
    return Distrust(snapshots.status());
  }
  return snapshots;
}

absl::Status Shard::StreamError(absl::Status status) const {
  // No server has these to say of a request of a stream.
  if (absl::IsDataLoss(status) || absl::IsInternal(status)) {
    return Distrust(status);
  }
  return status;
}

absl::Status Shard::Distrust(const absl::Status& why) const {
  return terms_->nodes->Distrust(placement_->node->node_id, why);
}

void Shard::SetWaits(bool waits, const absl::Status& why) {
  if (waits == waits_) {
    return;
  }
  waits_ = waits;
  terms_->metrics->AddFleetWaits(waits ? 1 : -1);
  if (waits) {
    LogEvent(LogLevel::kWarning, "shard_waiting",
             {{"pool", terms_->label},
              {"environments", Environments()},
              {"message", std::string(why.message())}});
  }
}

void Shard::Lose(const absl::Status& why) {
  if (!placement_.has_value()) {
    SetWaits(true, why);
    return;
  }
  const std::string& node_id = placement_->node->node_id;
  terms_->metrics->AddFleetShardMigration();
  LogEvent(LogLevel::kWarning, "shard_lost",
           {{"pool", terms_->label},
            {"environments", Environments()},
            {"node", node_id},
            {"code", absl::StatusCodeToString(why.code())},
            {"message", std::string(why.message())}});
  terms_->nodes->Suspect(node_id);
  Leave();
}

void Shard::Leave() {
  if (!placement_.has_value()) {
    return;
  }
  {
    absl::MutexLock lock(&mutex_);
    node_id_.clear();
    stream_ = nullptr;
  }
  placement_->stream->Cancel();
  const std::string pool_id = placement_->pool_id;
  const std::string node_id = placement_->node->node_id;
  placement_.reset();
  terms_->leftovers->EndUse(pool_id, node_id);
}

void Shard::PromoteBase(int64_t number) {
  // All shards have done what was before `number`, so nobody will go back beyond that, but to
  // answer again.
  if (!next_base_.has_value() ||
      !next_base_->IsUsable(*terms_->log, range_, number, terms_->answers_kept)) {
    return;
  }
  base_ = std::move(next_base_->base);
  next_base_.reset();
  if (terms_->on_base != nullptr) {
    terms_->on_base(range_, base_);
  }
  base_number_ = base_->number;
}

void Shard::SaveBase() {
  const bool is_due = position_ - base_->number >= terms_->options->snapshot_requests ||
                      (position_ > base_->number &&
                       terms_->log->BytesAfter(base_->number) >= terms_->options->snapshot_bytes);
  if (!is_due || next_base_.has_value() || !placement_.has_value() || position_ < save_position_) {
    return;
  }
  absl::StatusOr<std::vector<std::string>> states = FetchStates({});
  if (!states.ok()) {
    if (IsOfNode(states.status())) {
      Lose(states.status());
      return;
    }
    // A state that cannot be saved stays.
    save_position_ = position_ + terms_->options->snapshot_requests / 4;
    LogEvent(LogLevel::kWarning, "checkpoint_failed",
             {{"pool", terms_->label},
              {"environments", Environments()},
              {"code", absl::StatusCodeToString(states.status().code())},
              {"message", std::string(states.status().message())}});
    return;
  }
  ShardBase base = {position_, *std::move(states), sampler_};
  next_base_ = SavedBase{std::make_shared<const ShardBase>(std::move(base))};
}

}  // namespace procgen
