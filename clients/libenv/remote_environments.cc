#include "clients/libenv/remote_environments.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "clients/libenv/tensor_types.h"

namespace procgen {
namespace {

// Timeouts of connecting and reconnecting. Short, because the host blocks meanwhile.
constexpr absl::Duration kConnectTimeout = absl::Seconds(5);
constexpr absl::Duration kReconnectTimeout = absl::Seconds(5);
// Lease of the pool, which frees it after its host has gone. Longer than kReconnectTimeout.
constexpr int64_t kLeaseSeconds = 10;

v1::DistributionMode ModeOf(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
      return v1::DISTRIBUTION_MODE_EASY;
    case DistributionMode::kHard:
      return v1::DISTRIBUTION_MODE_HARD;
    case DistributionMode::kExtreme:
      return v1::DISTRIBUTION_MODE_EXTREME;
    case DistributionMode::kMemory:
      return v1::DISTRIBUTION_MODE_MEMORY;
    case DistributionMode::kExploration:
      return v1::DISTRIBUTION_MODE_EXPLORATION;
  }
  return v1::DISTRIBUTION_MODE_UNSPECIFIED;
}

v1::PoolSpec SpecOf(const PoolOptions& options) {
  v1::PoolSpec spec;
  for (const std::string& game : options.games) {
    spec.add_games(game);
  }
  spec.set_env_count(options.env_count);
  spec.mutable_lease_duration()->set_seconds(kLeaseSeconds);
  const EnvironmentOptions& from = options.environment;
  v1::EnvironmentOptions& to = *spec.mutable_options();
  to.set_distribution_mode(ModeOf(from.distribution_mode));
  to.set_num_levels(from.num_levels);
  to.set_start_level(from.start_level);
  to.set_rand_seed(from.rand_seed);
  to.set_use_sequential_levels(from.use_sequential_levels);
  to.set_center_agent(from.center_agent);
  to.set_use_backgrounds(from.use_backgrounds);
  to.set_use_generated_assets(from.use_generated_assets);
  to.set_use_monochrome_assets(from.use_monochrome_assets);
  to.set_restrict_themes(from.restrict_themes);
  to.set_paint_vel_info(from.paint_vel_info);
  to.set_debug_mode(from.debug_mode);
  return spec;
}

// Bools as bytes, 0 or 1.
absl::Span<const uint8_t> Bytes(absl::Span<const bool> values) {
  static_assert(sizeof(bool) == 1);
  return {reinterpret_cast<const uint8_t*>(values.data()), values.size()};
}

}  // namespace

absl::StatusOr<std::unique_ptr<RemoteEnvironments>> RemoteEnvironments::Create(
    const std::string& address, const PoolOptions& options) {
  auto client = procgen_client::Client::Connect(address, {.timeout = kConnectTimeout});
  if (!client.ok()) {
    return client.status();
  }
  auto pool = (*client)->CreatePool(SpecOf(options));
  if (!pool.ok()) {
    return pool.status();
  }
  std::unique_ptr<RemoteEnvironments> environments(
      new RemoteEnvironments(*std::move(client), pool->name()));
  auto stream =
      environments->client_->Attach(pool->name(), {.reconnect_timeout = kReconnectTimeout});
  if (!stream.ok()) {
    return stream.status();
  }
  environments->stream_ = *std::move(stream);
  if (absl::Status status = environments->stream_->Observe(&environments->batch_); !status.ok()) {
    return status;
  }
  return environments;
}

RemoteEnvironments::RemoteEnvironments(std::unique_ptr<procgen_client::Client> client,
                                       std::string pool)
    : client_(std::move(client)), pool_(std::move(pool)) {}

RemoteEnvironments::~RemoteEnvironments() {
  stream_.reset();
  client_->DeletePool(pool_).IgnoreError();
}

absl::Status RemoteEnvironments::Act(absl::Span<const int32_t> actions) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  absl::Status status = stream_->SendStep(actions).status();
  is_stepping_ = status.ok();
  return status;
}

absl::StatusOr<EnvironmentValues> RemoteEnvironments::Observe() {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  return EnvironmentValues{.observations = batch_.observations(),
                           .rewards = batch_.rewards(),
                           .first = Bytes(batch_.first()),
                           .prev_level_seeds = batch_.prev_level_seeds(),
                           .prev_level_complete = Bytes(batch_.prev_level_complete()),
                           .level_seeds = batch_.level_seeds()};
}

absl::Status RemoteEnvironments::Render(int32_t environment, absl::Span<uint8_t> frame) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  auto drawn = client_->RenderEnvironments(pool_, {environment}, kHumanViewSizePx);
  if (!drawn.ok()) {
    return drawn.status();
  }
  if (drawn->frames_size() != 1 || drawn->frames(0).image().size() != frame.size()) {
    return absl::InternalError(
        "the server returned another number or size of frames than requested");
  }
  const std::string& image = drawn->frames(0).image();
  std::copy(image.begin(), image.end(), frame.begin());
  return absl::OkStatus();
}

absl::StatusOr<std::string> RemoteEnvironments::SaveState(int32_t environment) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  auto states = client_->SaveStates(pool_, {environment});
  if (!states.ok()) {
    return states.status();
  }
  if (states->size() != 1) {
    return absl::InternalError("the server returned another number of snapshots than requested");
  }
  return std::move(*states->front().mutable_snapshot());
}

absl::Status RemoteEnvironments::RestoreState(int32_t environment, absl::string_view snapshot) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  v1::State state;
  state.set_environment(environment);
  state.set_snapshot(std::string(snapshot));
  if (absl::Status status = client_->RestoreStates(pool_, {state}); !status.ok()) {
    return status;
  }
  return stream_->Observe(&batch_);
}

absl::Status RemoteEnvironments::Wait() {
  if (!is_stepping_) {
    return absl::OkStatus();
  }
  is_stepping_ = false;
  return stream_->Receive(&batch_);
}

}  // namespace procgen
