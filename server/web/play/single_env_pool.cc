#include "server/web/play/single_env_pool.h"

#include <algorithm>
#include <utility>

#include "absl/random/random.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

constexpr absl::string_view kPrefix = "web-";
// Lease of a pool, for when its page cannot delete it.
constexpr int64_t kLeaseSeconds = 60;
// Pipelined steps when intermediate results are not needed.
constexpr int32_t kRequestsInFlight = 8;

v1::StepPoolRequest StepRequestOf(int32_t action, v1::Observation observation) {
  v1::StepPoolRequest request;
  request.mutable_step()->add_actions(action);
  request.mutable_step()->set_observation(observation);
  return request;
}

}  // namespace

absl::StatusOr<v1::Pool> MakePagePool(procgen_client::Client* client, absl::string_view kind,
                                      v1::PoolSpec spec) {
  absl::BitGen random;
  const std::string id = absl::StrCat(kPrefix, kind, "-",
                                      absl::Hex(absl::Uniform<uint64_t>(random), absl::kZeroPad16));
  spec.mutable_lease_duration()->set_seconds(kLeaseSeconds);
  return client->CreatePool(spec, id);
}

std::string KindOfPool(absl::string_view name) {
  if (absl::ConsumePrefix(&name, "pools/") && absl::ConsumePrefix(&name, kPrefix)) {
    for (const absl::string_view kind : {"play", "replay", "gallery"}) {
      absl::string_view rest = name;
      if (absl::ConsumePrefix(&rest, kind) && absl::ConsumePrefix(&rest, "-")) {
        return std::string(kind);
      }
    }
  }
  return "pool";
}

absl::StatusOr<std::unique_ptr<SingleEnvPool>> SingleEnvPool::Make(
    std::shared_ptr<procgen_client::Client> client, absl::string_view kind,
    const v1::PoolSpec& spec) {
  const absl::StatusOr<v1::Catalog> catalog = client->GetCatalog();
  if (!catalog.ok()) {
    return catalog.status();
  }
  v1::PoolSpec own_spec = spec;
  // Keeps the last state of an episode until the next step, so that it can be drawn.
  own_spec.set_autoreset_mode(v1::AUTORESET_MODE_NEXT_STEP);
  absl::StatusOr<v1::Pool> made = MakePagePool(client.get(), kind, std::move(own_spec));
  if (!made.ok()) {
    return made.status();
  }
  std::unique_ptr<SingleEnvPool> pool(new SingleEnvPool(std::move(client), *std::move(made)));
  procgen_client::StreamOptions options;
  options.requests_in_flight_max =
      std::min(kRequestsInFlight, catalog->limits().requests_in_flight_max());
  // No reconnects: the in-process connection does not break.
  options.reconnect_timeout = absl::ZeroDuration();
  auto stream = pool->client_->Attach(pool->name_, options);
  if (!stream.ok()) {
    return stream.status();
  }
  pool->stream_ = *std::move(stream);
  return pool;
}

SingleEnvPool::SingleEnvPool(std::shared_ptr<procgen_client::Client> client, v1::Pool pool)
    : client_(std::move(client)), name_(pool.name()), spec_(std::move(*pool.mutable_spec())) {}

SingleEnvPool::~SingleEnvPool() {
  stream_.reset();
  client_->DeletePool(name_).IgnoreError();  // on failure, the lease expires
}

Row SingleEnvPool::RowOf() const {
  Row row;
  row.reward = batch_.rewards()[0];
  row.first = batch_.first()[0];
  row.level_seed = batch_.level_seeds()[0];
  row.prev_level_seed = batch_.prev_level_seeds()[0];
  row.prev_level_complete = batch_.prev_level_complete()[0];
  row.episode_return = batch_.episode_returns()[0];
  row.episode_length = batch_.episode_lengths()[0];
  if (!batch_.fingerprints().empty()) {
    row.fingerprint = batch_.fingerprints()[0];
  }
  const absl::Span<const uint8_t> picture = batch_.observations();
  row.picture.assign(picture.begin(), picture.end());
  return row;
}

absl::StatusOr<Row> SingleEnvPool::Call(v1::StepPoolRequest request) {
  if (absl::Status status = stream_->Call(std::move(request), &batch_); !status.ok()) {
    return status;
  }
  return RowOf();
}

absl::StatusOr<Row> SingleEnvPool::Observe() {
  v1::StepPoolRequest request;
  request.mutable_observe();
  return Call(std::move(request));
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
  if (!row.ok() || !HasEnded()) {
    return row;
  }
  row->final_picture = std::move(row->picture);
  if (human_size_px > 0) {
    absl::StatusOr<std::string> human = Draw(human_size_px);
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
  const auto ahead = static_cast<size_t>(stream_->requests_in_flight_max());
  bool is_as_announced = true;
  for (size_t sent = 0, received = 0; received < actions.size(); ++received) {
    const auto may_send = [&] {
      return is_as_announced && sent < actions.size() && sent - received < ahead &&
             (sent == received || !may_end(sent - 1));
    };
    for (; may_send(); ++sent) {
      const auto number = stream_->Send(StepRequestOf(actions[sent], v1::OBSERVATION_NONE));
      if (!number.ok()) {
        return number.status();
      }
    }
    if (absl::Status status = stream_->Receive(&batch_); !status.ok()) {
      return status;
    }
    if (!is_as_announced) {
      if (received + 1 == sent) {
        break;  // all responses to what was sent too early were read
      }
      continue;
    }
    Row row = RowOf();
    if (HasEnded()) {
      is_as_announced = received + 1 == sent;
      if (is_as_announced) {
        if (absl::Status status = BeginEpisode(v1::OBSERVATION_NONE, &row); !status.ok()) {
          return status;
        }
      }
    }
    add(row);
  }
  return is_as_announced;
}

absl::StatusOr<v1::State> SingleEnvPool::Save() {
  absl::StatusOr<std::vector<v1::State>> states = client_->SaveStates(name_);
  if (!states.ok()) {
    return states.status();
  }
  return std::move(states->front());
}

absl::Status SingleEnvPool::Restore(const v1::State& state) {
  return client_->RestoreStates(name_, {state});
}

absl::StatusOr<std::string> SingleEnvPool::Draw(int32_t size_px, v1::FrameView view) {
  return DrawPng(client_.get(), name_, 0, size_px, view);
}

absl::StatusOr<std::string> DrawPng(procgen_client::Client* client, const std::string& pool,
                                    int32_t environment, int32_t size_px, v1::FrameView view) {
  auto response =
      client->RenderEnvironments(pool, {environment}, size_px, v1::FRAME_FORMAT_PNG, view);
  if (!response.ok()) {
    return response.status();
  }
  return std::move(*response->mutable_frames(0)->mutable_image());
}

}  // namespace procgen::web
