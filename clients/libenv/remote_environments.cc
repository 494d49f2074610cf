#include "clients/libenv/remote_environments.h"

#include <chrono>
#include <utility>

#include "absl/time/time.h"
#include "clients/libenv/tensor_types.h"
#include "procgen_client/servers.h"

namespace procgen {
namespace {

// Timeouts of connecting and reconnecting. Short, because the host blocks meanwhile.
constexpr absl::Duration kConnectTimeout = absl::Seconds(5);
constexpr absl::Duration kReconnectTimeout = absl::Seconds(5);

}  // namespace

absl::StatusOr<std::unique_ptr<RemoteEnvironments>> RemoteEnvironments::Create(
    const std::string& addresses, const PoolOptions& options) {
  const auto servers = procgen_client::Servers::Connect(addresses, {.timeout = kConnectTimeout});
  if (!servers.ok()) {
    return servers.status();
  }
  procgen_client::RemotePoolOptions remote;
  remote.recovery.reconnect_timeout = kReconnectTimeout;
  auto pool = procgen_client::CreatePool(*servers, options, remote);
  if (!pool.ok()) {
    return pool.status();
  }
  std::unique_ptr<RemoteEnvironments> environments(new RemoteEnvironments(*std::move(pool)));
  if (absl::Status status = environments->ObservePool(); !status.ok()) {
    return status;
  }
  return environments;
}

RemoteEnvironments::RemoteEnvironments(std::unique_ptr<procgen_client::Pool> pool)
    : observations_(static_cast<size_t>(pool->options().env_count) * kObservationBytes),
      pool_(std::move(pool)) {}

absl::Status RemoteEnvironments::Act(absl::Span<const int32_t> actions) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  return pool_->Send({.count = pool_->options().env_count, .actions = actions}, {}, OwnBatch());
}

absl::StatusOr<EnvironmentValues> RemoteEnvironments::Observe() {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  return EnvironmentValues{.observations = observations_,
                           .rewards = numbers_.rewards,
                           .first = numbers_.first,
                           .prev_level_seeds = numbers_.prev_level_seeds,
                           .prev_level_complete = numbers_.prev_level_complete,
                           .level_seeds = numbers_.level_seeds};
}

absl::Status RemoteEnvironments::Render(int32_t environment, absl::Span<uint8_t> frame) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  return pool_->Render(environment, kHumanViewSizePx, /*whole_level=*/false, frame);
}

absl::StatusOr<std::string> RemoteEnvironments::SaveState(int32_t environment) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  auto snapshots = pool_->SaveStates({environment});
  if (!snapshots.ok()) {
    return snapshots.status();
  }
  return std::move(snapshots->front());
}

absl::Status RemoteEnvironments::RestoreState(int32_t environment, absl::string_view snapshot) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  const StateToRestore state = {.environment = environment, .snapshot = snapshot};
  if (absl::Status status = pool_->RestoreStates({state}); !status.ok()) {
    return status;
  }
  return ObservePool();
}

absl::Status RemoteEnvironments::Wait() {
  return pool_->unanswered_count() == 0 ? OkStatus()
                                        : pool_->Receive(std::chrono::duration<double>(-1));
}

absl::Status RemoteEnvironments::ObservePool() {
  return pool_->Step({.count = pool_->options().env_count, .steps = false}, {}, OwnBatch());
}

Batch RemoteEnvironments::OwnBatch() {
  Batch batch;
  batch.observations = absl::MakeSpan(observations_);
  return numbers_.ReplaceEmptyArrays(batch, pool_->options().env_count);
}

}  // namespace procgen
