#include "server/fleet/pool/remote_pool.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "server/fleet/log/shard_request.h"
#include "server/fleet/nodes/node_answers.h"
#include "server/fleet/timing.h"

namespace procgen {
namespace {

// Requests in flight during a replay.
constexpr int32_t kReplayedInFlightMax = 16;

}  // namespace

absl::StatusOr<std::unique_ptr<RemotePool>> RemotePool::Create(
    const ShardContext& context, Part range, const ShardCheckpoint& checkpoint, std::string pool_id,
    FleetNodes::CapacityReservation capacity, std::shared_ptr<NodeClient> node) {
  std::unique_ptr<RemotePool> pool(new RemotePool(context, range, checkpoint, std::move(pool_id),
                                                  std::move(capacity), std::move(node)));
  if (absl::Status status = pool->CreatePool(checkpoint); !status.ok()) {
    context.nodes->Suspect(pool->node_id());
    return status;
  }
  return pool;
}

RemotePool::RemotePool(const ShardContext& context, Part range, const ShardCheckpoint& checkpoint,
                       std::string pool_id, FleetNodes::CapacityReservation capacity,
                       std::shared_ptr<NodeClient> node)
    : context_(context),
      range_(range),
      pool_id_(std::move(pool_id)),
      capacity_(std::move(capacity)),
      node_(std::move(node)),
      position_(checkpoint.number),
      sampler_(checkpoint.sampler) {
  context_.orphan_collector->BeginUse(pool_id_);
}

RemotePool::~RemotePool() {
  if (stream_ != nullptr) {
    stream_->Cancel();
  }
  const std::string node_id = node_->node_id;
  stream_.reset();
  node_.reset();
  capacity_ = {};
  context_.orphan_collector->EndUse(pool_id_, node_id);
}

absl::Status RemotePool::CreatePool(const ShardCheckpoint& checkpoint) {
  procgen_client::Client* const client = node_->client.get();
  v1::PoolSpec spec = context_.spec;
  spec.set_env_count(range_.count);
  spec.set_first_env(spec.first_env() + range_.first);
  spec.mutable_lease_duration()->set_seconds(
      std::min(kShardLeaseSeconds, node_->limits.lease_duration_max().seconds()));
  if (checkpoint.sampler != nullptr) {
    *spec.mutable_level_sampler() = *checkpoint.sampler;
  }
  const absl::StatusOr<v1::Pool> pool = client->CreatePool(spec, pool_id_);
  if (!pool.ok()) {
    return pool.status();
  }
  if (absl::Status status = CheckNodePool(*pool, spec, pool_id_); !status.ok()) {
    return Distrust(status);
  }
  name_ = pool->name();
  if (absl::Status status = Attach(); !status.ok()) {
    return status;
  }
  std::vector<v1::State> states(checkpoint.states.size());
  for (size_t i = 0; i < states.size(); ++i) {
    states[i].set_environment(static_cast<int32_t>(i));
    states[i].set_snapshot(checkpoint.states[i]);
  }
  return states.empty() ? absl::OkStatus() : client->RestoreStates(name_, states);
}

absl::Status RemotePool::Attach() {
  procgen_client::StreamOptions options;
  options.requests_in_flight_max =
      std::min(kReplayedInFlightMax, node_->limits.requests_in_flight_max());
  options.response_bytes_max = node_->limits.response_bytes_max();
  options.pipe_transport = false;  // pools of a fleet share no memory, even if a node offers it
  // A break ends the epoch, so the node keeps no answers.
  options.reconnect_timeout = absl::ZeroDuration();
  auto stream = node_->client->Attach(name_, options);
  if (!stream.ok()) {
    // Servers never return these for attach; the client does for a wrong answer.
    const bool is_wrong = absl::IsInternal(stream.status()) || absl::IsDataLoss(stream.status());
    return is_wrong ? Distrust(stream.status()) : stream.status();
  }
  stream_ = *std::move(stream);
  const absl::Status status =
      CheckNodeStream(*stream_, range_.count, options.requests_in_flight_max);
  return status.ok() ? status : Distrust(status);
}

absl::Status RemotePool::AdvanceTo(int64_t number, int64_t replay_end,
                                   procgen_client::Batch* answer) {
  while (position_ < number) {
    const RequestLog::Entry logged = context_.log->requests().Find(position_ + 1);
    const bool is_executed = position_ + 1 == number && number > replay_end;
    absl::Status status = is_executed ? Execute(*logged, answer) : Replay(*logged);
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

absl::Status RemotePool::Replay(const LoggedRequest& logged) {
  if (!logged.states.empty()) {
    return ApplyStates(logged);
  }
  std::optional<v1::StepPoolRequest> request = CutRequest(logged.request, range_);
  if (!request.has_value() || request->has_observe()) {
    return absl::OkStatus();
  }
  DisableObservations(&*request);
  if (unanswered_ == stream_->requests_in_flight_max()) {
    if (absl::Status status = stream_->Receive(&replayed_); !status.ok()) {
      return StreamError(std::move(status));
    }
    --unanswered_;
  }
  ++unanswered_;
  return StreamError(stream_->Send(*std::move(request)).status());
}

absl::Status RemotePool::Execute(const LoggedRequest& logged, procgen_client::Batch* answer) {
  if (!logged.states.empty()) {
    return ApplyStates(logged);
  }
  std::optional<v1::StepPoolRequest> request = CutRequest(logged.request, range_);
  absl::Status status = ReceiveAll();
  if (!status.ok() || !request.has_value()) {
    return status;
  }
  if (request->has_step()) {
    request->mutable_step()->set_chunk_count(stream_->chunk_count());
  }
  const bool has_rows = !request->has_level_sampler();
  const RequestedRows asked = AskedRowsOf(*request);
  status = StreamError(stream_->Call(*std::move(request), answer));
  if (status.ok() && has_rows) {
    status = CheckNodeBatch(*answer, asked, context_.observation_bytes);
    return status.ok() ? status : Distrust(status);
  }
  return status;
}

absl::Status RemotePool::ApplyStates(const LoggedRequest& logged) {
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
  return states.empty() ? absl::OkStatus() : node_->client->RestoreStates(name_, states);
}

absl::Status RemotePool::ReceiveAll() {
  for (; unanswered_ > 0; --unanswered_) {
    if (absl::Status status = stream_->Receive(&replayed_); !status.ok()) {
      return StreamError(std::move(status));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> RemotePool::SaveStates(
    absl::Span<const int32_t> environments) const {
  auto states = node_->client->SaveStates(name_, environments, node_->limits.response_bytes_max());
  if (!states.ok()) {
    return states.status();
  }
  auto snapshots = TakeNodeStates(*std::move(states), environments, range_.count);
  if (!snapshots.ok()) {
    return Distrust(snapshots.status());
  }
  return snapshots;
}

absl::Status RemotePool::Render(absl::Span<const int32_t> environments, View view, int32_t size_px,
                                const std::vector<absl::Span<uint8_t>>& frames) const {
  const v1::FrameView frame_view = view == View::kAgent   ? v1::FRAME_VIEW_AGENT
                                   : view == View::kLevel ? v1::FRAME_VIEW_LEVEL
                                                          : v1::FRAME_VIEW_HUMAN;
  for (size_t i = 0; i < environments.size(); ++i) {
    const auto rendered = node_->client->RenderEnvironments(name_, {&environments[i], 1}, size_px,
                                                            v1::FRAME_FORMAT_RGB, frame_view);
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
}

absl::Status RemotePool::StreamError(absl::Status status) const {
  // Servers never return these for a request of a stream.
  if (absl::IsDataLoss(status) || absl::IsInternal(status)) {
    return Distrust(status);
  }
  return status;
}

absl::Status RemotePool::Distrust(const absl::Status& why) const {
  return context_.nodes->Distrust(node_->node_id, why);
}

}  // namespace procgen
