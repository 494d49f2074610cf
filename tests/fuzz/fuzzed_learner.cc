#include "tests/fuzz/fuzzed_learner.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "procgen_client/client.h"
#include "tests/fuzz/pieces.h"

namespace procgen {
namespace {

using procgen_client::Batch;
using procgen_client::StepStream;

constexpr int32_t kEnvCount = 3;
constexpr int32_t kSizePx = 16;
constexpr char kPoolId[] = "answers";
constexpr char kPool[] = "pools/answers";

v1::PoolSpec SpecFor(const LearnerOptions& options) {
  v1::PoolSpec spec;
  spec.add_games("maze");
  spec.set_env_count(kEnvCount);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec.mutable_options()->set_rand_seed(5);
  spec.mutable_observation_format()->set_color(v1::COLOR_GRAYSCALE);
  spec.mutable_observation_format()->set_size_px(kSizePx);
  spec.set_encoding(options.observations == 1 ? v1::ENCODING_DELTA_ZSTD : v1::ENCODING_RAW);
  if (options.observations == 3) {
    spec.set_transport(v1::TRANSPORT_SHARED_MEMORY);
  }
  return spec;
}

// Reads all bytes, so that AddressSanitizer detects arrays beyond their memory. Reads bools as
// bytes, because shared memory may contain values other than 0 and 1.
template <typename Element>
void ReadBytes(absl::Span<const Element> values) {
  const volatile auto* const bytes = reinterpret_cast<const uint8_t*>(values.data());
  for (size_t i = 0; i < values.size() * sizeof(Element); ++i) {
    static_cast<void>(bytes[i]);
  }
}

template <typename Element>
void ReadRows(absl::Span<const Element> values, size_t count) {
  Require(values.size() == count, "each array of a batch has a row for each environment");
  ReadBytes(values);
}

void ReadBatch(const StepStream& stream, const Batch& batch) {
  Require(batch.env_count() >= 0 && batch.first_env() >= 0 &&
              batch.env_count() <= stream.env_count() - batch.first_env(),
          "a batch is of environments of the pool");
  const auto count = static_cast<size_t>(batch.env_count());
  const auto bytes = static_cast<size_t>(stream.pool().observation_bytes());
  ReadRows(batch.rewards(), count);
  ReadRows(batch.first(), count);
  ReadRows(batch.terminated(), count);
  ReadRows(batch.truncated(), count);
  ReadRows(batch.level_seeds(), count);
  ReadRows(batch.prev_level_seeds(), count);
  ReadRows(batch.prev_level_complete(), count);
  ReadRows(batch.episode_returns(), count);
  ReadRows(batch.episode_lengths(), count);
  ReadRows(batch.observations(), count * bytes);
  Require(batch.fingerprints().size() <= count, "there are no more fingerprints than environments");
  ReadBytes(batch.fingerprints());
  Require(batch.final_observations().size() % bytes == 0 &&
              batch.final_observations().size() <= count * bytes,
          "final observations are whole and of environments of the batch");
  ReadBytes(batch.final_observations());
}

// Returns whether it is OK.
bool IsDocumented(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kDeadlineExceeded:
      Require(false, "an answer is an error of a documented code", status);
      return false;
    default:
      return status.ok();
  }
}

void ReadAnswer(const StepStream& stream, const Batch& batch, const absl::Status& status) {
  if (IsDocumented(status)) {
    ReadBatch(stream, batch);
  } else {
    Require(batch.env_count() == 0 && batch.observations().empty() && batch.rewards().empty() &&
                batch.final_observations().empty(),
            "nothing of a wrong answer can be read", status);
  }
}

void Step(StepStream* stream) {
  // Uses the pool that this learner created, whichever pool the server attached it to.
  const std::vector<int32_t> actions(kEnvCount, 4);
  Batch batch;
  ReadAnswer(*stream, batch, stream->Observe(&batch));
  for (const int32_t chunk_count : {1, 1, 2}) {
    v1::StepPoolRequest request;
    request.mutable_step()->mutable_actions()->Assign(actions.begin(), actions.end());
    request.mutable_step()->set_with_final_observations(true);
    request.mutable_step()->set_chunk_count(chunk_count);
    Batch answer;  // A new batch each time; after an error it is empty.
    ReadAnswer(*stream, answer, stream->Call(request, &answer));
  }
  v1::LevelSampler sampler;
  sampler.add_level_seeds(3);
  sampler.add_weights(1);
  IsDocumented(stream->SetLevelSampler(sampler));
  v1::StepPoolRequest observe;
  observe.mutable_observe()->mutable_slice()->set_first_env(1);
  observe.mutable_observe()->mutable_slice()->set_env_count(1);
  Batch part;
  ReadAnswer(*stream, part, stream->Call(observe, &part));
  const bool is_sent = stream->SendStep(actions).ok() && stream->SendStep(actions).ok();
  for (int i = 0; is_sent && i < 2; ++i) {
    Batch answer;
    ReadAnswer(*stream, answer, stream->Receive(&answer));
  }
  ReadBatch(*stream, batch);  // In shared memory the batch is still held.
  IsDocumented(stream->Close());
}

void CallOthers(procgen_client::Client* client) {
  IsDocumented(client->GetCatalog().status());
  IsDocumented(client->GetPool(kPool).status());
  IsDocumented(client->ListPools().status());
  IsDocumented(client->SaveStates(kPool, {2, 0}).status());
  IsDocumented(client->SaveStates(kPool).status());
  IsDocumented(client->GetEpisode(kPool, 0, v1::EPISODE_SELECTOR_CURRENT).status());
  const auto frames = client->RenderEnvironments(kPool, {1, 2}, kSizePx);
  if (IsDocumented(frames.status())) {
    for (const v1::Frame& frame : frames->frames()) {
      Require(frame.image().size() == size_t{kSizePx} * kSizePx * 3, "frames are whole");
    }
  }
  v1::WatchPoolRequest request;
  request.set_pool(kPool);
  request.add_environments(1);
  request.set_size_px(kSizePx);
  const auto watch = client->Watch(request);
  IsDocumented(watch->Next().status());
}

}  // namespace

void RunLearner(const std::shared_ptr<grpc::Channel>& channel, LearnerOptions options) {
  const auto client = procgen_client::Client::FromChannel(channel, "");
  IsDocumented(client->CreatePool(SpecFor(options), kPoolId).status());
  if (!options.uses_stream) {
    return CallOthers(client.get());
  }
  const auto stream = client->Attach(
      kPool, {.reconnect_timeout = options.resumes ? absl::Seconds(1) : absl::ZeroDuration(),
              .chunk_count = 1,
              .pipe_transport = false});
  if (IsDocumented(stream.status())) {
    Step(stream->get());
  }
}

}  // namespace procgen
