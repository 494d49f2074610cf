#include "server/web/play/single_env_pool.h"

#include <utility>

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

v1::RunPoolRequest StepRequestOf(int32_t action, v1::Observation observation) {
  v1::RunPoolRequest request;
  request.mutable_step()->mutable_slice()->set_env_count(1);
  request.mutable_step()->add_actions(action);
  request.mutable_step()->set_observation(observation);
  return request;
}

}  // namespace

absl::StatusOr<std::unique_ptr<SingleEnvPool>> SingleEnvPool::Make(
    std::shared_ptr<procgen_client::Client> client, absl::string_view kind,
    const v1::PoolSpec& spec) {
  v1::PoolSpec own_spec = spec;
  own_spec.set_env_count(1);
  // Keeps the last state of an episode until the next step, so that it can be drawn.
  own_spec.set_autoreset_mode(v1::AUTORESET_MODE_NEXT_STEP);
  absl::StatusOr<std::unique_ptr<PagePool>> pool =
      PagePool::Start(std::move(client), kind, own_spec);
  if (!pool.ok()) {
    return pool.status();
  }
  return std::unique_ptr<SingleEnvPool>(new SingleEnvPool(*std::move(pool)));
}

absl::StatusOr<Row> SingleEnvPool::Call(const v1::RunPoolRequest& request) {
  if (absl::Status status = pool_->Send(request); !status.ok()) {
    return status;
  }
  return Receive();
}

absl::StatusOr<Row> SingleEnvPool::Receive() {
  absl::StatusOr<v1::RunPoolResponse> response = pool_->Receive();
  if (!response.ok()) {
    return response.status();
  }
  v1::Batch* batch = response->mutable_batch();
  Row row;
  row.reward = batch->rewards(0);
  row.first = batch->first(0);
  row.level_seed = batch->level_seeds(0);
  row.prev_level_seed = batch->prev_level_seeds(0);
  row.prev_level_complete = batch->prev_level_complete(0);
  row.episode_return = batch->episode_returns(0);
  row.episode_length = batch->episode_lengths(0);
  if (!batch->fingerprints().empty()) {
    row.fingerprint = static_cast<uint64_t>(batch->fingerprints(0));
  }
  row.picture = std::move(*batch->mutable_observations());
  has_ended_ = batch->terminated(0) || batch->truncated(0);
  return row;
}

absl::StatusOr<Row> SingleEnvPool::Observe() {
  v1::RunPoolRequest request;
  request.mutable_observe()->mutable_slice()->set_env_count(1);
  return Call(request);
}

absl::Status SingleEnvPool::BeginEpisode(v1::Observation observation, Row* row) {
  // Its action is ignored.
  absl::StatusOr<Row> start = Call(StepRequestOf(0, observation));
  if (!start.ok()) {
    return start.status();
  }
  row->first = true;
  row->level_seed = start->level_seed;
  row->picture = std::move(start->picture);
  return absl::OkStatus();
}

absl::StatusOr<Row> SingleEnvPool::Step(int32_t action, int32_t human_size_px) {
  absl::StatusOr<Row> row = Call(StepRequestOf(action, v1::OBSERVATION_FRAME));
  if (!row.ok() || !has_ended_) {
    return row;
  }
  row->final_picture = std::move(row->picture);
  if (human_size_px > 0) {
    absl::StatusOr<std::string> human = Draw(human_size_px, v1::FRAME_VIEW_HUMAN);
    if (!human.ok()) {
      return human.status();
    }
    row->final_human = *std::move(human);
  }
  if (absl::Status status = BeginEpisode(v1::OBSERVATION_FRAME, &*row); !status.ok()) {
    return status;
  }
  return row;
}

absl::StatusOr<bool> SingleEnvPool::StepAll(absl::Span<const int32_t> actions,
                                            absl::FunctionRef<bool(size_t)> may_end,
                                            absl::FunctionRef<void(const Row&)> add) {
  bool is_as_announced = true;
  for (size_t sent = 0, received = 0; received < actions.size(); ++received) {
    const auto may_send = [&] {
      return is_as_announced && sent < actions.size() && sent - received < PagePool::kAheadMax &&
             (sent == received || !may_end(sent - 1));
    };
    for (; may_send(); ++sent) {
      absl::Status status = pool_->Send(StepRequestOf(actions[sent], v1::OBSERVATION_NONE));
      if (!status.ok()) {
        return status;
      }
    }
    absl::StatusOr<Row> row = Receive();
    if (!row.ok()) {
      return row.status();
    }
    if (!is_as_announced) {
      if (received + 1 == sent) {
        break;  // all responses to what was sent too early were read
      }
      continue;
    }
    if (has_ended_) {
      is_as_announced = received + 1 == sent;
      if (is_as_announced) {
        if (absl::Status status = BeginEpisode(v1::OBSERVATION_NONE, &*row); !status.ok()) {
          return status;
        }
      }
    }
    add(*row);
  }
  return is_as_announced;
}

absl::StatusOr<v1::State> SingleEnvPool::Save() {
  v1::RunPoolRequest request;
  request.mutable_save_states();
  absl::StatusOr<v1::RunPoolResponse> response = pool_->Call(request);
  if (!response.ok()) {
    return response.status();
  }
  return std::move(*response->mutable_states()->mutable_states(0));
}

absl::Status SingleEnvPool::Restore(const v1::State& state) {
  v1::RunPoolRequest request;
  *request.mutable_restore_states()->add_states() = state;
  return pool_->Call(request).status();
}

absl::StatusOr<std::string> SingleEnvPool::Draw(int32_t size_px, v1::FrameView view) {
  return pool_->Draw(0, size_px, view);
}

}  // namespace procgen::web
