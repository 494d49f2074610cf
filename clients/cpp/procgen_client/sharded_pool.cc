#include "procgen_client/sharded_pool.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "envcore/pool/pool_input.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen_client/run/step_part.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

constexpr absl::Duration kDescribeTimeout = absl::Seconds(2);
constexpr absl::Duration kAttemptTimeout = absl::Seconds(1);

// What a server offers and how much of a pool it gets.
struct ServerState {
  std::shared_ptr<Client> client;
  v1::Limits limits;
  double weight = 0;
};

// The servers that answer. Errors: UNAVAILABLE none does.
absl::StatusOr<std::vector<ServerState>> Describe(
    const std::vector<std::shared_ptr<Client>>& servers) {
  std::vector<ServerState> states;
  absl::Status error = absl::UnavailableError("there are no servers");
  for (const std::shared_ptr<Client>& server : servers) {
    const auto catalog =
        server->Call("/procgen.v1.CatalogService/GetCatalog", "", kDescribeTimeout);
    const auto load = catalog.ok()
                          ? server->Call("/procgen.v1.CatalogService/GetLoad", "", kDescribeTimeout)
                          : catalog;
    v1::Catalog described;
    v1::Load loaded;
    if (!load.ok()) {
      error = load.status();
    } else if (described.ParseFromString(*catalog) && loaded.ParseFromString(*load) &&
               !loaded.draining()) {
      // A thread that other pools use, too, counts as a part of one.
      const double threads = std::max(loaded.worker_count(), 1);
      states.push_back({.client = server,
                        .limits = described.limits(),
                        .weight = threads * threads / (threads + loaded.pool_count())});
    }
  }
  if (states.empty()) {
    return error;
  }
  return states;
}

// The error of a slice, whose message counts environments from its first one.
procgen::Status ErrorOfSlice(const procgen::Status& status, int32_t first) {
  if (status.ok() || first == 0) {
    return status;
  }
  return {status.code(), absl::StrCat("in the slice that begins with environment ", first, ": ",
                                      status.message())};
}

// Divides `count` environments by weight; each server gets at least one if there are enough.
std::vector<int32_t> SliceSizes(const std::vector<ServerState>& states, int32_t count) {
  double weight_left = 0;
  for (const ServerState& state : states) {
    weight_left += state.weight;
  }
  std::vector<int32_t> sizes;
  int32_t left = count;
  for (size_t i = 0; i < states.size(); ++i) {
    const auto servers_behind = static_cast<int32_t>(states.size() - i - 1);
    const auto share = static_cast<int32_t>(std::lround(left * states[i].weight / weight_left));
    const int32_t size = servers_behind == 0
                             ? left
                             : std::clamp(share, std::min(left, 1),
                                          std::max(left - servers_behind, std::min(left, 1)));
    sizes.push_back(size);
    left -= size;
    weight_left -= states[i].weight;
  }
  return sizes;
}

}  // namespace

procgen::StatusOr<std::unique_ptr<Pool>> ShardedPool::Create(
    const std::shared_ptr<Servers>& servers, const procgen::PoolOptions& options,
    const RemotePoolOptions& remote) {
  if (procgen::Status status = procgen::CheckPoolOptions(options); !status.ok()) {
    return status;
  }
  const auto states = Describe(servers->All());
  if (!states.ok()) {
    return procgen::Status(states.status().code(), states.status().message());
  }
  v1::Limits limits = states->front().limits;
  for (const ServerState& state : *states) {
    limits.set_request_bytes_max(
        std::min(limits.request_bytes_max(), state.limits.request_bytes_max()));
    limits.set_response_bytes_max(
        std::min(limits.response_bytes_max(), state.limits.response_bytes_max()));
  }
  std::unique_ptr<ShardedPool> sharded(new ShardedPool(options));
  const std::vector<int32_t> sizes = SliceSizes(*states, options.env_count);
  const int32_t total = options.total_env_count != 0 ? options.total_env_count
                                                     : options.first_env + options.env_count;
  const auto events = std::make_shared<EventQueue>();
  std::vector<std::string> names;
  int32_t first = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] == 0) {
      continue;
    }
    procgen::PoolOptions slice = options;
    slice.env_count = sizes[i];
    slice.first_env = options.first_env + first;
    slice.total_env_count = total;
    RemotePoolOptions slice_remote = remote;
    slice_remote.recovery.attempt_timeout = kAttemptTimeout;
    if (!remote.pool_id.empty()) {
      slice_remote.pool_id = absl::StrCat(remote.pool_id, "-", i);
    }
    auto pool =
        RemotePool::Create(servers, (*states)[i].client, limits, slice, slice_remote, events);
    if (!pool.ok()) {
      return pool.status();
    }
    names.push_back((*pool)->name());
    sharded->shards_.push_back({.first = first, .count = sizes[i], .pool = *std::move(pool)});
    first += sizes[i];
  }
  sharded->name_ = absl::StrJoin(names, ",");
  return sharded;
}

procgen::Status ShardedPool::CheckEnvironment(int32_t environment) const {
  if (environment < 0 || environment >= options_.env_count) {
    return procgen::InvalidArgumentError(
        absl::StrCat("environment is ", environment, ", must be in [0, ", options_.env_count, ")"));
  }
  return procgen::OkStatus();
}

ShardedPool::Shard& ShardedPool::ShardOf(int32_t environment) {
  return *std::find_if(shards_.begin(), shards_.end(), [environment](const Shard& shard) {
    return environment < shard.first + shard.count;
  });
}

procgen::Status ShardedPool::Send(const procgen::StepInput& input,
                                  absl::Span<const Annotation> annotations,
                                  const procgen::Batch& batch) {
  const size_t observation_bytes = options_.observation_format.bytes();
  if (procgen::Status status =
          procgen::CheckStep(input, batch, options_.env_count, observation_bytes);
      !status.ok()) {
    return status;
  }
  if (procgen::Status status = CheckRoom(); !status.ok()) {
    return status;
  }
  Request request;
  for (size_t i = 0; i < shards_.size(); ++i) {
    Shard& shard = shards_[i];
    const int32_t begin = std::max(input.first, shard.first);
    const int32_t end = std::min(input.first + input.count, shard.first + shard.count);
    if (begin >= end) {
      continue;
    }
    StepPart part(input, annotations, batch, begin - input.first, end - begin, observation_bytes);
    part.RenumberFrom(shard.first);
    if (procgen::Status status = shard.pool->Send(part.input, part.annotations, part.batch);
        !status.ok()) {
      // Only the first can fail: it would be lost for good otherwise.
      if (request.asked.empty()) {
        return status;
      }
      request.error = status;
      continue;
    }
    request.asked.push_back(i);
  }
  unanswered_.push_back(std::move(request));
  return procgen::OkStatus();
}

procgen::Status ShardedPool::Receive(std::chrono::duration<double> timeout) {
  if (unanswered_.empty()) {
    return procgen::FailedPreconditionError("no request is unanswered: send one first");
  }
  constexpr auto kNone = std::chrono::duration<double>::zero();
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  Request& request = unanswered_.front();
  while (!request.asked.empty()) {
    const std::chrono::duration<double> left = deadline - std::chrono::steady_clock::now();
    const Shard& shard = shards_[request.asked.front()];
    procgen::Status status = shard.pool->Receive(timeout < kNone ? timeout : std::max(left, kNone));
    if (status.code() == absl::StatusCode::kDeadlineExceeded) {
      return status;
    }
    if (request.error.ok()) {
      request.error = ErrorOfSlice(status, shard.first);
    }
    request.asked.pop_front();
  }
  procgen::Status error = std::move(request.error);
  unanswered_.pop_front();
  return error;
}

procgen::Status ShardedPool::SetLevelSampler(
    std::shared_ptr<const procgen::LevelSampler> level_sampler) {
  procgen::Status status = CheckIdle();
  for (Shard& shard : shards_) {
    if (status.ok()) {
      status = shard.pool->SetLevelSampler(level_sampler);
    }
  }
  return status;
}

procgen::StatusOr<std::vector<std::string>> ShardedPool::SaveStates(
    absl::Span<const int32_t> environments) {
  if (procgen::Status status = CheckIdle(); !status.ok()) {
    return status;
  }
  for (const int32_t environment : environments) {
    if (procgen::Status status = CheckEnvironment(environment); !status.ok()) {
      return status;
    }
  }
  std::vector<std::string> snapshots(environments.size());
  for (Shard& shard : shards_) {
    std::vector<int32_t> saved;
    std::vector<size_t> places;
    for (size_t i = 0; i < environments.size(); ++i) {
      if (&ShardOf(environments[i]) == &shard) {
        saved.push_back(environments[i] - shard.first);
        places.push_back(i);
      }
    }
    auto states = shard.pool->SaveStates(saved);
    if (!states.ok()) {
      return states.status();
    }
    for (size_t i = 0; i < places.size(); ++i) {
      snapshots[places[i]] = std::move((*states)[i]);
    }
  }
  return snapshots;
}

procgen::Status ShardedPool::RestoreStates(absl::Span<const procgen::StateToRestore> states) {
  procgen::Status status = CheckIdle();
  for (const procgen::StateToRestore& state : states) {
    if (status.ok()) {
      status = CheckEnvironment(state.environment);
    }
  }
  for (Shard& shard : shards_) {
    std::vector<procgen::StateToRestore> restored;
    for (const procgen::StateToRestore& state : states) {
      if (status.ok() && &ShardOf(state.environment) == &shard) {
        restored.push_back(
            {.environment = state.environment - shard.first, .snapshot = state.snapshot});
      }
    }
    if (status.ok() && !restored.empty()) {
      status = ErrorOfSlice(shard.pool->RestoreStates(restored), shard.first);
    }
  }
  return status;
}

procgen::Status ShardedPool::CloneStates(absl::Span<const procgen::StateToClone> pairs) {
  std::vector<int32_t> sources;
  for (const procgen::StateToClone& pair : pairs) {
    sources.push_back(pair.source_environment);
  }
  // All sources are read before any target is written.
  const auto snapshots = SaveStates(sources);
  if (!snapshots.ok()) {
    return snapshots.status();
  }
  std::vector<procgen::StateToRestore> states;
  for (size_t i = 0; i < pairs.size(); ++i) {
    states.push_back({.environment = pairs[i].target_environment, .snapshot = (*snapshots)[i]});
  }
  return RestoreStates(states);
}

procgen::Status ShardedPool::Render(int32_t environment, int32_t size_px, bool whole_level,
                                    absl::Span<uint8_t> frame) {
  procgen::Status status = CheckIdle();
  if (status.ok()) {
    status = CheckEnvironment(environment);
  }
  if (!status.ok()) {
    return status;
  }
  Shard& shard = ShardOf(environment);
  return shard.pool->Render(environment - shard.first, size_px, whole_level, frame);
}

}  // namespace procgen_client
