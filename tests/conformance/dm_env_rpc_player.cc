#include "tests/conformance/dm_env_rpc_player.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "dm_env_rpc/v1/dm_env_rpc.grpc.pb.h"
#include "grpcpp/grpcpp.h"

namespace procgen {
namespace {

namespace dm = ::dm_env_rpc::v1;

constexpr uint64_t kAction = 1;
// UIDs, as listed in server/dm_env_rpc/README.md.
constexpr uint64_t kRgb = 1;
constexpr uint64_t kReward = 2;
constexpr uint64_t kLevelSeed = 3;
constexpr uint64_t kPrevLevelSeed = 4;
constexpr uint64_t kPrevLevelComplete = 5;
constexpr uint64_t kFirst = 9;

dm::Tensor Integer(int64_t value) {
  dm::Tensor tensor;
  tensor.mutable_int64s()->add_array(value);
  return tensor;
}

dm::CreateWorldRequest CreateRequest(const Trace& trace) {
  dm::CreateWorldRequest request;
  auto& settings = *request.mutable_settings();
  for (const std::string& game : trace.games) {
    settings["env_name"].mutable_strings()->add_array(game);
  }
  settings["env_name"].add_shape(static_cast<int32_t>(trace.games.size()));
  const EnvironmentOptions& options = trace.options;
  settings["distribution_mode"] = Integer(static_cast<int64_t>(options.distribution_mode));
  settings["num_levels"] = Integer(options.num_levels);
  settings["start_level"] = Integer(options.start_level);
  settings["rand_seed"] = Integer(options.rand_seed);
  settings["use_sequential_levels"] = Integer(static_cast<int64_t>(options.use_sequential_levels));
  settings["center_agent"] = Integer(static_cast<int64_t>(options.center_agent));
  settings["use_backgrounds"] = Integer(static_cast<int64_t>(options.use_backgrounds));
  settings["use_generated_assets"] = Integer(static_cast<int64_t>(options.use_generated_assets));
  settings["use_monochrome_assets"] = Integer(static_cast<int64_t>(options.use_monochrome_assets));
  settings["restrict_themes"] = Integer(static_cast<int64_t>(options.restrict_themes));
  settings["paint_vel_info"] = Integer(static_cast<int64_t>(options.paint_vel_info));
  settings["debug_mode"] = Integer(options.debug_mode);
  return request;
}

// A dm_env_rpc agent that has created and joined a world.
class Agent {
 public:
  static absl::StatusOr<std::unique_ptr<Agent>> Join(const std::string& address,
                                                     const dm::CreateWorldRequest& create) {
    auto agent = std::make_unique<Agent>(address);
    dm::EnvironmentRequest request;
    *request.mutable_create_world() = create;
    const absl::StatusOr<dm::EnvironmentResponse> created = agent->Ask(request);
    if (!created.ok()) {
      return created.status();
    }
    request.mutable_join_world()->set_world_name(created->create_world().world_name());
    const absl::StatusOr<dm::EnvironmentResponse> joined = agent->Ask(request);
    if (!joined.ok()) {
      return joined.status();
    }
    return agent;
  }

  explicit Agent(const std::string& address)
      : stream_(dm::Environment::NewStub(
                    grpc::CreateChannel(address, grpc::InsecureChannelCredentials()))
                    ->Process(&context_)) {}
  ~Agent() {
    stream_->WritesDone();
    stream_->Finish();
  }
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  absl::StatusOr<dm::StepResponse> Step(absl::Span<const int32_t> actions, bool is_list,
                                        const std::vector<uint64_t>& observations) {
    dm::EnvironmentRequest request;
    dm::StepRequest& step = *request.mutable_step();
    step.mutable_requested_observations()->Assign(observations.begin(), observations.end());
    if (!actions.empty()) {
      dm::Tensor& action = (*step.mutable_actions())[kAction];
      action.mutable_int32s()->mutable_array()->Assign(actions.begin(), actions.end());
      if (is_list) {
        action.add_shape(static_cast<int32_t>(actions.size()));
      }
    }
    absl::StatusOr<dm::EnvironmentResponse> response = Ask(request);
    if (!response.ok()) {
      return response.status();
    }
    return std::move(*response->mutable_step());
  }

 private:
  absl::StatusOr<dm::EnvironmentResponse> Ask(const dm::EnvironmentRequest& request) {
    dm::EnvironmentResponse response;
    if (!stream_->Write(request) || !stream_->Read(&response)) {
      return absl::UnavailableError("the stream has ended");
    }
    if (response.has_error()) {
      return absl::Status(static_cast<absl::StatusCode>(response.error().code()),
                          response.error().message());
    }
    return response;
  }

  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<dm::EnvironmentRequest, dm::EnvironmentResponse>>
      stream_;
};

// Appends the rows of a batch's tensor, or the scalar of a single environment.
template <typename Array, typename Element>
void Append(const Array& array, std::vector<Element>* elements) {
  elements->insert(elements->end(), array.begin(), array.end());
}

std::vector<uint64_t> Wanted(bool with_pictures) {
  std::vector<uint64_t> wanted = {kReward, kLevelSeed, kPrevLevelSeed, kPrevLevelComplete};
  if (with_pictures) {
    wanted.push_back(kRgb);
  }
  return wanted;
}

// Appends the fields of the episode that was stepped; AppendShown those of the observation.
void AppendOutcome(const dm::StepResponse& step, Observations* observed) {
  Append(step.observations().at(kReward).floats().array(), &observed->rewards);
  Append(step.observations().at(kPrevLevelSeed).int32s().array(), &observed->prev_level_seeds);
  Append(step.observations().at(kPrevLevelComplete).bools().array(),
         &observed->prev_level_complete);
}
void AppendShown(const dm::StepResponse& step, Observations* observed) {
  Append(step.observations().at(kLevelSeed).int32s().array(), &observed->level_seeds);
  if (const auto rgb = step.observations().find(kRgb); rgb != step.observations().end()) {
    Append(rgb->second.uint8s().array(), &observed->observations);
  }
}

// All environments as one batched world.
class BatchPlayer final : public Player {
 public:
  BatchPlayer(std::unique_ptr<Agent> agent, bool with_pictures)
      : agent_(std::move(agent)), wanted_(Wanted(with_pictures)) {
    wanted_.push_back(kFirst);
  }

  absl::Status Observe(Observations* observed) override { return Step({}, observed); }

  absl::Status Step(absl::Span<const int32_t> actions, Observations* observed) override {
    const absl::StatusOr<dm::StepResponse> step = agent_->Step(actions, true, wanted_);
    if (!step.ok()) {
      return step.status();
    }
    *observed = Observations();
    AppendOutcome(*step, observed);
    AppendShown(*step, observed);
    Append(step->observations().at(kFirst).bools().array(), &observed->first);
    return absl::OkStatus();
  }

 private:
  const std::unique_ptr<Agent> agent_;
  std::vector<uint64_t> wanted_;
};

// Each environment as a separate world. Where a step ends an episode, upstream returns the first
// observation of the next one; dm_env_rpc needs another step for it.
class SinglesPlayer final : public Player {
 public:
  SinglesPlayer(std::vector<std::unique_ptr<Agent>> agents, bool with_pictures)
      : agents_(std::move(agents)), wanted_(Wanted(with_pictures)) {}

  absl::Status Observe(Observations* observed) override {
    *observed = Observations();
    for (const std::unique_ptr<Agent>& agent : agents_) {
      const absl::StatusOr<dm::StepResponse> begun = agent->Step({}, false, wanted_);
      if (!begun.ok()) {
        return begun.status();
      }
      AppendOutcome(*begun, observed);
      AppendShown(*begun, observed);
      observed->first.push_back(1);
    }
    return absl::OkStatus();
  }

  absl::Status Step(absl::Span<const int32_t> actions, Observations* observed) override {
    *observed = Observations();
    for (size_t i = 0; i < agents_.size(); ++i) {
      absl::StatusOr<dm::StepResponse> step =
          agents_[i]->Step(actions.subspan(i, 1), false, wanted_);
      if (!step.ok()) {
        return step.status();
      }
      AppendOutcome(*step, observed);
      const bool ended = step->state() != dm::RUNNING;
      if (ended) {
        step = agents_[i]->Step({}, false, wanted_);
        if (!step.ok()) {
          return step.status();
        }
      }
      AppendShown(*step, observed);
      observed->first.push_back(ended ? 1 : 0);
    }
    return absl::OkStatus();
  }

 private:
  const std::vector<std::unique_ptr<Agent>> agents_;
  const std::vector<uint64_t> wanted_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Player>> MakeBatchedWorldPlayer(const Trace& trace,
                                                               const std::string& address,
                                                               bool with_pictures) {
  dm::CreateWorldRequest create = CreateRequest(trace);
  (*create.mutable_settings())["num_envs"] = Integer(trace.env_count);
  absl::StatusOr<std::unique_ptr<Agent>> agent = Agent::Join(address, create);
  if (!agent.ok()) {
    return agent.status();
  }
  return std::make_unique<BatchPlayer>(*std::move(agent), with_pictures);
}

absl::StatusOr<std::unique_ptr<Player>> MakeSingleWorldsPlayer(const Trace& trace,
                                                               const std::string& address,
                                                               bool with_pictures) {
  std::vector<std::unique_ptr<Agent>> agents;
  for (int32_t i = 0; i < trace.env_count; ++i) {
    dm::CreateWorldRequest create = CreateRequest(trace);
    (*create.mutable_settings())["first_env"] = Integer(i);
    (*create.mutable_settings())["total_env_count"] = Integer(trace.env_count);
    absl::StatusOr<std::unique_ptr<Agent>> agent = Agent::Join(address, create);
    if (!agent.ok()) {
      return agent.status();
    }
    agents.push_back(*std::move(agent));
  }
  return std::make_unique<SinglesPlayer>(std::move(agents), with_pictures);
}

}  // namespace procgen
