#include <utility>

#include "procgen_client/client.h"
#include "tools/conformance/player.h"

namespace procgen {
namespace {

procgen::v1::DistributionMode ModeOf(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
      return procgen::v1::DISTRIBUTION_MODE_EASY;
    case DistributionMode::kHard:
      return procgen::v1::DISTRIBUTION_MODE_HARD;
    case DistributionMode::kExtreme:
      return procgen::v1::DISTRIBUTION_MODE_EXTREME;
    case DistributionMode::kMemory:
      return procgen::v1::DISTRIBUTION_MODE_MEMORY;
    case DistributionMode::kExploration:
      return procgen::v1::DISTRIBUTION_MODE_EXPLORATION;
  }
  return procgen::v1::DISTRIBUTION_MODE_UNSPECIFIED;
}

procgen::v1::PoolSpec SpecOf(const Trace& trace) {
  procgen::v1::PoolSpec spec;
  for (const std::string& game : trace.games) {
    spec.add_games(game);
  }
  spec.set_env_count(trace.env_count);
  procgen::v1::EnvironmentOptions& options = *spec.mutable_options();
  options.set_distribution_mode(ModeOf(trace.options.distribution_mode));
  options.set_num_levels(trace.options.num_levels);
  options.set_start_level(trace.options.start_level);
  options.set_rand_seed(trace.options.rand_seed);
  options.set_use_sequential_levels(trace.options.use_sequential_levels);
  options.set_center_agent(trace.options.center_agent);
  options.set_use_backgrounds(trace.options.use_backgrounds);
  options.set_use_generated_assets(trace.options.use_generated_assets);
  options.set_use_monochrome_assets(trace.options.use_monochrome_assets);
  options.set_restrict_themes(trace.options.restrict_themes);
  options.set_paint_vel_info(trace.options.paint_vel_info);
  options.set_debug_mode(trace.options.debug_mode);
  return spec;
}

// Plays on a pool of the server. Deletes the pool when destroyed.
class RemotePlayer final : public Player {
 public:
  RemotePlayer(std::unique_ptr<procgen_client::Client> client, std::string pool,
               std::unique_ptr<procgen_client::StepStream> stream, bool with_pictures)
      : client_(std::move(client)),
        pool_(std::move(pool)),
        stream_(std::move(stream)),
        with_pictures_(with_pictures) {}

  ~RemotePlayer() override {
    stream_.reset();
    client_->DeletePool(pool_).IgnoreError();
  }

  absl::Status Observe(Observations* observed) override {
    procgen::v1::StepPoolRequest request;
    request.mutable_observe()->set_observation(WantedObservation());
    return Call(std::move(request), observed);
  }

  absl::Status Step(absl::Span<const int32_t> actions, Observations* observed) override {
    procgen::v1::StepPoolRequest request;
    request.mutable_step()->set_observation(WantedObservation());
    request.mutable_step()->mutable_actions()->Add(actions.begin(), actions.end());
    return Call(std::move(request), observed);
  }

 private:
  procgen::v1::Observation WantedObservation() const {
    return with_pictures_ ? procgen::v1::OBSERVATION_FRAME : procgen::v1::OBSERVATION_NONE;
  }

  absl::Status Call(procgen::v1::StepPoolRequest request, Observations* observed) {
    if (absl::Status status = stream_->Call(std::move(request), &batch_); !status.ok()) {
      return status;
    }
    const auto copy = [](const auto& from, auto* to) { to->assign(from.begin(), from.end()); };
    copy(batch_.rewards(), &observed->rewards);
    copy(batch_.first(), &observed->first);
    copy(batch_.level_seeds(), &observed->level_seeds);
    copy(batch_.prev_level_seeds(), &observed->prev_level_seeds);
    copy(batch_.prev_level_complete(), &observed->prev_level_complete);
    copy(batch_.observations(), &observed->observations);
    return absl::OkStatus();
  }

  const std::unique_ptr<procgen_client::Client> client_;
  const std::string pool_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  const bool with_pictures_;
  procgen_client::Batch batch_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Player>> MakeRemotePlayer(const Trace& trace,
                                                         const std::string& address,
                                                         bool with_pictures) {
  auto client = procgen_client::Client::Connect(address);
  if (!client.ok()) {
    return client.status();
  }
  auto pool = (*client)->CreatePool(SpecOf(trace));
  if (!pool.ok()) {
    return pool.status();
  }
  auto stream = (*client)->Attach(pool->name());
  if (!stream.ok()) {
    (*client)->DeletePool(pool->name()).IgnoreError();
    return stream.status();
  }
  return std::make_unique<RemotePlayer>(*std::move(client), pool->name(), *std::move(stream),
                                        with_pictures);
}

}  // namespace procgen
