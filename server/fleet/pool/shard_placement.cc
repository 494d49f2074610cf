// Where a shard is: how it comes to a node.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/fleet/nodes/node_answers.h"
#include "server/fleet/pool/shard.h"
#include "server/fleet/timing.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

// How many requests are sent ahead where they are repeated.
constexpr int32_t kRepeatedAhead = 16;

}  // namespace

absl::Status Shard::Place() {
  absl::StatusOr<FleetNodes::Seat> seat = terms_->nodes->Take(range_.count, preferred_node_);
  if (!seat.ok()) {
    return seat.status();
  }
  Placement placement;
  placement.seat = *std::move(seat);
  const std::string& node_id = placement.seat.node_id();
  absl::StatusOr<std::shared_ptr<NodeClient>> node = terms_->nodes->Connect(node_id);
  if (!node.ok()) {
    terms_->nodes->Suspect(node_id);
    return node.status();
  }
  placement.node = *std::move(node);
  placement.pool_id = absl::StrCat(terms_->id_prefix, number_, "-", ++epoch_);
  terms_->leftovers->BeginUse(placement.pool_id);
  if (absl::Status status = Fill(&placement); !status.ok()) {
    terms_->nodes->Suspect(node_id);
    terms_->leftovers->EndUse(placement.pool_id, node_id);
    return status;
  }
  position_ = base_->number;
  sampler_ = base_->sampler;
  unanswered_ = 0;
  preferred_node_ = node_id;
  LogEvent(LogLevel::kInfo, "shard_placed",
           {{"pool", terms_->label},
            {"environments", Environments()},
            {"node", node_id},
            {"shard", placement.pool},
            {"from", absl::StrCat(base_->number)}});
  {
    absl::MutexLock lock(&mutex_);
    node_id_ = node_id;
    stream_ = placement.stream;
    placement_ = std::move(placement);
  }
  SetWaits(false);
  return absl::OkStatus();
}

absl::Status Shard::Fill(Placement* placement) {
  procgen_client::Client* const client = placement->node->client.get();
  const v1::Limits& limits = placement->node->limits;
  v1::PoolSpec spec = terms_->spec;
  spec.set_env_count(range_.count);
  spec.set_first_env(spec.first_env() + range_.first);
  spec.mutable_lease_duration()->set_seconds(
      std::min(kShardLeaseSeconds, limits.lease_duration_max().seconds()));
  if (base_->sampler != nullptr) {
    *spec.mutable_level_sampler() = *base_->sampler;
  }
  const absl::StatusOr<v1::Pool> pool = client->CreatePool(spec, placement->pool_id);
  if (!pool.ok()) {
    return pool.status();
  }
  const std::string& node_id = placement->node->node_id;
  if (absl::Status status = CheckNodePool(*pool, spec, placement->pool_id); !status.ok()) {
    return terms_->nodes->Distrust(node_id, status);
  }
  placement->pool = pool->name();
  procgen_client::StreamOptions options;
  options.requests_in_flight_max = std::min(kRepeatedAhead, limits.requests_in_flight_max());
  options.response_bytes_max = limits.response_bytes_max();
  options.pipe_transport = false;  // pools of a fleet share no memory, whatever a node says
  // Whatever breaks ends an epoch; the node need keep no answers.
  options.reconnect_timeout = absl::ZeroDuration();
  auto stream = client->Attach(placement->pool, options);
  if (!stream.ok()) {
    // No server has these to say of attach; the client has, of what it was answered.
    const bool is_wrong = absl::IsInternal(stream.status()) || absl::IsDataLoss(stream.status());
    return is_wrong ? terms_->nodes->Distrust(node_id, stream.status()) : stream.status();
  }
  placement->stream = *std::move(stream);
  if (absl::Status status =
          CheckNodeStream(*placement->stream, range_.count, options.requests_in_flight_max);
      !status.ok()) {
    return terms_->nodes->Distrust(node_id, status);
  }
  std::vector<v1::State> states(base_->states.size());
  for (size_t i = 0; i < states.size(); ++i) {
    states[i].set_environment(static_cast<int32_t>(i));
    states[i].set_snapshot(base_->states[i]);
  }
  return states.empty() ? absl::OkStatus() : client->RestoreStates(placement->pool, states);
}

}  // namespace procgen
