#include "procgen_client/remote_pool.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "envcore/pool/pool_input.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "procgen_client/internal/pool_messages.h"
#include "procgen_client/run/step_part.h"
#include "procgen_client/servers.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

constexpr absl::Duration kCloseTimeout = absl::Seconds(1);

procgen::Status StatusOf(const absl::Status& status) { return {status.code(), status.message()}; }

absl::Span<uint8_t> Sized(std::vector<uint8_t>* bytes, size_t size) {
  bytes->resize(size);
  return absl::MakeSpan(*bytes);
}

}  // namespace

procgen::StatusOr<std::unique_ptr<Pool>> RemotePool::Create(std::shared_ptr<Client> client,
                                                            const procgen::PoolOptions& options,
                                                            const RemotePoolOptions& remote) {
  if (procgen::Status status = procgen::CheckPoolOptions(options); !status.ok()) {
    return status;
  }
  const absl::StatusOr<v1::Catalog> catalog = client->GetCatalog();
  if (!catalog.ok()) {
    return StatusOf(catalog.status());
  }
  return Create(nullptr, std::move(client), catalog->limits(), options, remote,
                std::make_shared<EventQueue>());
}

procgen::StatusOr<std::unique_ptr<Pool>> RemotePool::Create(
    std::shared_ptr<Servers> servers, std::shared_ptr<Client> home, const v1::Limits& limits,
    const procgen::PoolOptions& options, const RemotePoolOptions& remote,
    const std::shared_ptr<EventQueue>& events) {
  if (procgen::Status status = procgen::CheckPoolOptions(options); !status.ok()) {
    return status;
  }
  std::unique_ptr<RemotePool> pool(new RemotePool(options));
  pool->request_bytes_max_ = limits.request_bytes_max();
  pool->response_bytes_max_ = limits.response_bytes_max();
  pool->states_per_request_ = static_cast<size_t>(StatesPerRequest(limits.response_bytes_max()));
  procgen::PoolOptions unstacked = options;
  unstacked.observation_format.frame_stack = 1;
  v1::StartPool start;
  start.set_pool_id(remote.pool_id);
  *start.mutable_spec() = SpecOf(unstacked, remote.encoding);
  start.mutable_spec()->set_display_name(remote.display_name);
  start.mutable_spec()->mutable_labels()->insert(remote.labels.begin(), remote.labels.end());
  RecoveryOptions recovery = remote.recovery;
  recovery.request_bytes_max = limits.request_bytes_max();
  recovery.response_bytes_max = limits.response_bytes_max();
  const std::shared_ptr<OpenCalls> calls = home->calls();
  const auto place = std::make_shared<PoolPlace>(std::move(servers), std::move(home));
  recovery.has_better_server = [place] { return place->IsHomeBack(); };
  pool->stream_ = std::make_unique<RecoveringStream>(
      std::move(start), std::move(recovery),
      [place, events](int attempt) { return place->Next(attempt)->OpenRunPool(events); });
  pool->entry_.emplace(calls, [stream = pool->stream_.get()] { stream->Cancel(); });
  if (const absl::Status status = pool->Start(); !status.ok()) {
    return StatusOf(status);
  }
  return pool;
}

absl::Status RemotePool::Start() {
  const absl::StatusOr<v1::Started> started = stream_->Start();
  if (!started.ok()) {
    return started.status();
  }
  pool_ = started->pool();
  name_ = pool_.name();
  const procgen::ObservationFormat& format = options_.observation_format;
  if (pool_.spec().env_count() != options_.env_count ||
      pool_.observation_bytes() != static_cast<int64_t>(format.frame.bytes())) {
    return absl::InternalError(
        absl::StrCat("the server's answer: ", pool_.spec().env_count(),
                     " environments with observations of ", pool_.observation_bytes(),
                     " bytes, expected: ", options_.env_count, " with ", format.frame.bytes()));
  }
  // A server of an older version ignores the option.
  const std::string variant =
      procgen::VariantText(options_.environment.variant, options_.environment.variant_value);
  if (pool_.spec().options().variant() != variant) {
    return absl::UnimplementedError(
        absl::StrCat("variant is \"", variant, "\", the server plays \"",
                     pool_.spec().options().variant(), "\": it is of another version"));
  }
  if (format.frame_stack == 1) {
    return absl::OkStatus();
  }
  stacks_.assign(static_cast<size_t>(options_.env_count),
                 procgen::FrameStack(format.frame.bytes(), format.frame_stack));
  return FillStacks();
}

RemotePool::~RemotePool() {
  if (stream_ != nullptr) {
    stream_->Close(kCloseTimeout);
  }
}

procgen::Status RemotePool::CheckReady() const {
  procgen::Status status = CheckIdle();
  return status.ok() ? StatusOf(stream_->ended()) : status;
}

procgen::Status RemotePool::Send(const procgen::StepInput& input,
                                 absl::Span<const Annotation> annotations,
                                 const procgen::Batch& batch) {
  if (procgen::Status status =
          procgen::CheckStep(input, batch, options_.env_count, options_.observation_format.bytes());
      !status.ok()) {
    return status;
  }
  if (procgen::Status status = CheckRoom(); !status.ok()) {
    return status;
  }
  if (!stream_->ended().ok()) {
    return StatusOf(stream_->ended());
  }
  const int32_t rows_max = RowsMax(batch);
  if (input.count <= rows_max) {
    SendPart(input, annotations, batch, /*is_last=*/true);
  }
  for (int32_t sent = 0; input.count > rows_max && sent < input.count;) {
    const int32_t count = std::min(rows_max, input.count - sent);
    const StepPart part(input, annotations, batch, sent, count,
                        options_.observation_format.bytes());
    sent += count;
    SendPart(part.input, part.annotations, part.batch, sent == input.count);
  }
  ++unanswered_count_;
  return procgen::OkStatus();
}

int32_t RemotePool::RowsMax(const procgen::Batch& batch) const {
  // An encoded observation may take a little more than its size; the numbers of a row less than 64.
  const auto frame_bytes = static_cast<int64_t>(options_.observation_format.frame.bytes());
  const int64_t row_bytes =
      256 + frame_bytes + frame_bytes / 256 + (batch.final_observations.empty() ? 0 : frame_bytes);
  return static_cast<int32_t>(
      std::clamp<int64_t>((response_bytes_max_ - 1024) / row_bytes, 1, options_.env_count));
}

void RemotePool::SendPart(const procgen::StepInput& input, absl::Span<const Annotation> annotations,
                          const procgen::Batch& batch, bool is_last) {
  Request request;
  request.shape = {.first = input.first,
                   .count = input.count,
                   .observation_bytes = options_.observation_format.frame.bytes()};
  request.steps = input.steps;
  for (const procgen::Reset& reset : input.resets) {
    request.resets.push_back(reset.environment);
  }
  request.batch = batch;
  // In other modes the last observation of an episode is among the observations.
  const bool wants_finals = input.steps && !batch.final_observations.empty();
  request.has_finals = wants_finals && options_.autoreset_mode == procgen::AutoresetMode::kSameStep;
  const bool changes = input.steps || !input.resets.empty();
  request.has_frames =
      is_stacked() ? changes : !batch.observations.empty() || (wants_finals && !request.has_finals);
  stream_->Send(
      RequestOf(input, annotations, {.current = request.has_frames, .final = request.has_finals}));
  request.is_last = is_last;
  unanswered_.push_back(std::move(request));
}

procgen::Status RemotePool::Receive(std::chrono::duration<double> timeout) {
  if (unanswered_.empty()) {
    return procgen::FailedPreconditionError("no request is unanswered: send one first");
  }
  const absl::Time deadline = timeout < std::chrono::duration<double>::zero()
                                  ? absl::InfiniteFuture()
                                  : SteadyNow() + absl::Seconds(timeout.count());
  bool is_last = false;
  while (!is_last) {
    auto response = stream_->Receive(deadline == absl::InfiniteFuture()
                                         ? absl::InfiniteDuration()
                                         : std::max(deadline - SteadyNow(), absl::ZeroDuration()));
    if (!response.has_value()) {
      return procgen::DeadlineExceededError("the oldest request is not answered yet");
    }
    const Request request = std::move(unanswered_.front());
    unanswered_.pop_front();
    is_last = request.is_last;
    absl::Status status = response->status();
    if (status.ok()) {
      const procgen::Batch read = ArraysFor(request);
      status = Read(**response, request.shape, read);
      if (status.ok()) {
        Finish(request, read);
      } else {
        stream_->SetEnded(status);
      }
    }
    part_error_.Update(status);
  }
  --unanswered_count_;
  return StatusOf(std::exchange(part_error_, absl::OkStatus()));
}

absl::Status RemotePool::Read(const grpc::ByteBuffer& response, const BatchShape& shape,
                              const procgen::Batch& batch) {
  if (pool_.spec().encoding() != v1::ENCODING_RAW && decoder_call_ != stream_->call_count()) {
    decoder_.emplace(options_.env_count, shape.observation_bytes);
    decoder_call_ = stream_->call_count();
  }
  return reader_.Read(response, shape, batch, decoder_.has_value() ? &*decoder_ : nullptr);
}

procgen::Batch RemotePool::ArraysFor(const Request& request) {
  const size_t bytes = static_cast<size_t>(request.shape.count) * request.shape.observation_bytes;
  procgen::Batch read = numbers_.ReplaceEmptyArrays(request.batch, request.shape.count);
  if (!request.has_frames) {
    read.observations = {};
  } else if (is_stacked() || read.observations.empty()) {
    read.observations = Sized(&frames_, bytes);
  }
  if (!request.has_finals) {
    read.final_observations = {};
  } else if (is_stacked()) {
    read.final_observations = Sized(&final_frames_, bytes);
  }
  return read;
}

void RemotePool::Finish(const Request& request, const procgen::Batch& read) {
  if (is_stacked()) {
    StackFrames(request, read);
    return;
  }
  if (!request.steps || request.has_finals || request.batch.final_observations.empty()) {
    return;
  }
  const size_t bytes = request.shape.observation_bytes;
  for (size_t row = 0; row < read.terminated.size(); ++row) {
    if (read.terminated[row] != 0 || read.truncated[row] != 0) {
      std::memcpy(&request.batch.final_observations[row * bytes], &read.observations[row * bytes],
                  bytes);
    }
  }
}

// As procgen::Pool stacks: a new episode begins with its first frame in all places; final
// observations contain frames of the episode that ended.
void RemotePool::StackFrames(const Request& request, const procgen::Batch& read) {
  const size_t frame_bytes = request.shape.observation_bytes;
  const size_t bytes = options_.observation_format.bytes();
  const auto push = [frame_bytes](absl::Span<const uint8_t> frames, size_t row,
                                  procgen::FrameStack* stack) {
    std::memcpy(stack->Next().data(), &frames[row * frame_bytes], frame_bytes);
  };
  for (size_t row = 0; row < read.first.size(); ++row) {
    const int32_t environment = request.shape.first + static_cast<int32_t>(row);
    procgen::FrameStack& stack = stacks_[static_cast<size_t>(environment)];
    const bool moved = request.steps || std::find(request.resets.begin(), request.resets.end(),
                                                  environment) != request.resets.end();
    if (moved) {
      const bool ended = read.terminated[row] != 0 || read.truncated[row] != 0;
      if (ended && request.has_finals) {
        push(read.final_observations, row, &stack);
        stack.CopyTo(request.batch.final_observations.subspan(row * bytes, bytes));
      }
      if (read.first[row] != 0) {
        stack.Clear();
      }
      push(read.observations, row, &stack);
      if (ended && !request.has_finals && request.steps &&
          !request.batch.final_observations.empty()) {
        stack.CopyTo(request.batch.final_observations.subspan(row * bytes, bytes));
      }
    }
    if (!request.batch.observations.empty()) {
      stack.CopyTo(request.batch.observations.subspan(row * bytes, bytes));
    }
  }
}

absl::Status RemotePool::FillStacks() {
  if (!is_stacked()) {
    return absl::OkStatus();
  }
  const size_t frame_bytes = options_.observation_format.frame.bytes();
  for (int32_t first = 0; first < options_.env_count;) {
    const int32_t count = std::min(RowsMax({}), options_.env_count - first);
    const BatchShape shape = {.first = first, .count = count, .observation_bytes = frame_bytes};
    stream_->Send(
        RequestOf({.first = first, .count = count, .steps = false}, {}, {.current = true}));
    auto response = stream_->Receive(absl::InfiniteDuration());
    if (!response->ok()) {
      return response->status();
    }
    procgen::Batch read = numbers_.ReplaceEmptyArrays({}, count);
    read.observations = Sized(&frames_, frame_bytes * static_cast<size_t>(count));
    if (absl::Status status = Read(**response, shape, read); !status.ok()) {
      return status;
    }
    for (int32_t row = 0; row < count; ++row) {
      procgen::FrameStack& stack = stacks_[static_cast<size_t>(first) + static_cast<size_t>(row)];
      if (stack.empty()) {
        std::memcpy(stack.Next().data(), &frames_[static_cast<size_t>(row) * frame_bytes],
                    frame_bytes);
      }
    }
    first += count;
  }
  return absl::OkStatus();
}

absl::StatusOr<v1::RunPoolResponse> RemotePool::Call(v1::RunPoolRequest request) {
  stream_->Send(std::move(request));
  auto received = stream_->Receive(absl::InfiniteDuration());
  if (!received->ok()) {
    return received->status();
  }
  v1::RunPoolResponse response;
  if (!grpc::SerializationTraits<v1::RunPoolResponse>::Deserialize(&**received, &response).ok()) {
    return absl::DataLossError("the server's response is malformed");
  }
  return response;
}

procgen::Status RemotePool::SetLevelSampler(
    std::shared_ptr<const procgen::LevelSampler> level_sampler) {
  if (procgen::Status status = CheckReady(); !status.ok()) {
    return status;
  }
  v1::RunPoolRequest request;
  *request.mutable_level_sampler() = MessageOf(*level_sampler);
  return StatusOf(Call(std::move(request)).status());
}

procgen::StatusOr<std::vector<std::string>> RemotePool::SaveStates(
    absl::Span<const int32_t> environments) {
  if (procgen::Status status = CheckReady(); !status.ok()) {
    return status;
  }
  std::vector<std::string> snapshots;
  for (size_t first = 0; first < environments.size();) {
    // A request names each environment once.
    const absl::Span<const int32_t> named = environments.subspan(first, states_per_request_);
    std::vector<int32_t> distinct(named.begin(), named.end());
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    v1::RunPoolRequest request;
    request.mutable_save_states()->mutable_environments()->Add(distinct.begin(), distinct.end());
    absl::StatusOr<v1::RunPoolResponse> response = Call(std::move(request));
    if (absl::IsResourceExhausted(response.status()) && states_per_request_ > 1) {
      states_per_request_ /= 2;
      continue;
    }
    if (!response.ok()) {
      return StatusOf(response.status());
    }
    first += named.size();
    const v1::States& states = response->states();
    if (states.states_size() != static_cast<int>(distinct.size())) {
      return procgen::Status(absl::StatusCode::kInternal,
                             absl::StrCat("the server's answer: ", states.states_size(),
                                          " snapshots, expected: ", distinct.size()));
    }
    for (const int32_t environment : named) {
      const auto at = std::lower_bound(distinct.begin(), distinct.end(), environment);
      snapshots.push_back(states.states(static_cast<int>(at - distinct.begin())).snapshot());
    }
  }
  return snapshots;
}

procgen::Status RemotePool::RestoreStates(absl::Span<const procgen::StateToRestore> states) {
  if (procgen::Status status = CheckReady(); !status.ok()) {
    return status;
  }
  v1::RunPoolRequest request;
  int64_t bytes = 0;
  absl::Status status;
  for (size_t i = 0; i < states.size() && status.ok(); ++i) {
    v1::State* message = request.mutable_restore_states()->add_states();
    message->set_environment(states[i].environment);
    message->set_snapshot(states[i].snapshot.data(), states[i].snapshot.size());
    bytes += static_cast<int64_t>(states[i].snapshot.size()) + 32;
    const bool is_last = i + 1 == states.size();
    if (is_last ||
        bytes + static_cast<int64_t>(states[i + 1].snapshot.size()) + 1024 > request_bytes_max_) {
      status = Call(std::exchange(request, {})).status();
      bytes = 0;
    }
  }
  if (status.ok() && is_stacked() && !states.empty()) {
    for (const procgen::StateToRestore& state : states) {
      stacks_[static_cast<size_t>(state.environment)].Clear();
    }
    status = FillStacks();
  }
  return StatusOf(status);
}

procgen::Status RemotePool::CloneStates(absl::Span<const procgen::StateToClone> pairs) {
  if (procgen::Status status = CheckReady(); !status.ok() || pairs.empty()) {
    return status;
  }
  v1::RunPoolRequest request;
  for (const procgen::StateToClone& pair : pairs) {
    v1::ClonePair* message = request.mutable_clone_states()->add_pairs();
    message->set_source_environment(pair.source_environment);
    message->set_target_environment(pair.target_environment);
  }
  absl::Status status = Call(std::move(request)).status();
  if (status.ok() && is_stacked()) {
    for (const procgen::StateToClone& pair : pairs) {
      stacks_[static_cast<size_t>(pair.target_environment)].Clear();
    }
    status = FillStacks();
  }
  return StatusOf(status);
}

procgen::Status RemotePool::Render(int32_t environment, int32_t size_px, bool whole_level,
                                   absl::Span<uint8_t> frame) {
  if (procgen::Status status = CheckReady(); !status.ok()) {
    return status;
  }
  if (size_px < procgen::kHumanViewSizePxMin || size_px > procgen::kHumanViewSizePxMax) {
    return procgen::InvalidArgumentError(absl::StrCat("size_px is ", size_px, ", must be in [",
                                                      procgen::kHumanViewSizePxMin, ", ",
                                                      procgen::kHumanViewSizePxMax, "]"));
  }
  const size_t bytes = static_cast<size_t>(size_px) * static_cast<size_t>(size_px) * 3;
  if (frame.size() != bytes) {
    return procgen::InvalidArgumentError(
        absl::StrCat("frame has ", frame.size(), " bytes, must have ", bytes));
  }
  v1::RunPoolRequest request;
  v1::Render* render = request.mutable_render();
  render->add_environments(environment);
  render->set_size_px(size_px);
  render->set_view(whole_level ? v1::FRAME_VIEW_LEVEL : v1::FRAME_VIEW_HUMAN);
  const absl::StatusOr<v1::RunPoolResponse> response = Call(std::move(request));
  if (!response.ok()) {
    return StatusOf(response.status());
  }
  const v1::Frames& frames = response->frames();
  if (frames.frames_size() != 1 || frames.frames(0).image().size() != bytes) {
    return {absl::StatusCode::kInternal,
            absl::StrCat("the server's answer: not one frame of ", bytes, " bytes")};
  }
  const std::string& image = frames.frames(0).image();
  std::copy(image.begin(), image.end(), frame.begin());
  return procgen::OkStatus();
}

}  // namespace procgen_client
