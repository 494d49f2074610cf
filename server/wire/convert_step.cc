#include "server/wire/convert_step.h"

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "envcore/pool/pool.h"
#include "server/encoding/observation_encoder.h"
#include "server/wire/convert_pool.h"

namespace procgen {
namespace {

// Upper bound of a row's numbers in a response, in bytes; all have a fixed size.
constexpr auto kRowNumberBytes = static_cast<int64_t>(
    std::accumulate(std::begin(kBatchNumberBytes), std::end(kBatchNumberBytes), size_t{0}));
// Upper bound of the tags and lengths of a response, in bytes.
constexpr int64_t kResponseOverheadBytes = 256;

absl::Status ReadObservation(v1::Observation observation, Request* request) {
  switch (observation) {
    case v1::OBSERVATION_UNSPECIFIED:
    case v1::OBSERVATION_FRAME:
      request->with_observations = true;
      return absl::OkStatus();
    case v1::OBSERVATION_NONE:
      request->with_observations = false;
      return absl::OkStatus();
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("observation is number ", static_cast<int>(observation),
                       ", allowed: OBSERVATION_NONE, OBSERVATION_FRAME"));
  }
}

void ReadResets(const google::protobuf::RepeatedPtrField<v1::Reset>& messages,
                RequestMemory* request) {
  for (const v1::Reset& message : messages) {
    Reset reset;
    reset.environment = message.environment();
    if (message.has_level_seed()) {
      reset.level_seed = message.level_seed();
    }
    if (message.has_rand_seed()) {
      reset.rand_seed = message.rand_seed();
    }
    request->resets.push_back(reset);
  }
  request->request.resets = request->resets;
}

void ReadSlice(const v1::Slice& slice, Request* request) {
  request->first = slice.first_env();
  request->count = slice.env_count();
}

absl::Status ReadStep(const v1::Step& step, RequestMemory* memory) {
  memory->request.kind = Request::Kind::kStep;
  ReadSlice(step.slice(), &memory->request);
  memory->request.actions =
      absl::MakeConstSpan(step.actions().data(), static_cast<size_t>(step.actions_size()));
  memory->request.repeat = step.repeat_count() == 0 ? 1 : step.repeat_count();
  for (const v1::NextLevel& message : step.next_levels()) {
    memory->next_levels.push_back({message.environment(), message.level_seed()});
  }
  memory->request.next_levels = memory->next_levels;
  ReadResets(step.resets(), memory);
  for (const v1::Annotation& message : step.annotations()) {
    memory->annotations.push_back(
        {message.name(),
         absl::MakeConstSpan(message.values().data(), static_cast<size_t>(message.values_size()))});
  }
  memory->request.annotations = memory->annotations;
  memory->request.with_final_observations = step.with_final_observations();
  memory->request.acknowledge_only = step.acknowledge_only();
  return ReadObservation(step.observation(), &memory->request);
}

absl::Status ReadSampler(const v1::LevelSampler& message, RequestMemory* memory) {
  absl::StatusOr<std::shared_ptr<const LevelSampler>> sampler =
      LevelSamplerOf("level_sampler", message);
  if (!sampler.ok()) {
    return sampler.status();
  }
  memory->request.kind = Request::Kind::kSample;
  memory->request.level_sampler = *std::move(sampler);
  memory->request.with_observations = false;
  return absl::OkStatus();
}

absl::Status ReadReset(const v1::ResetSlice& reset, RequestMemory* memory) {
  memory->request.kind = Request::Kind::kReset;
  ReadSlice(reset.slice(), &memory->request);
  ReadResets(reset.resets(), memory);
  memory->request.acknowledge_only = reset.acknowledge_only();
  return ReadObservation(reset.observation(), &memory->request);
}

absl::Status ReadObserve(const v1::Observe& observe, RequestMemory* memory) {
  memory->request.kind = Request::Kind::kObserve;
  ReadSlice(observe.slice(), &memory->request);
  return ReadObservation(observe.observation(), &memory->request);
}

}  // namespace

void RequestMemory::Clear() {
  next_levels.clear();
  resets.clear();
  annotations.clear();
  request = Request();
}

absl::Status ReadRequest(const v1::RunPoolRequest& message, RequestMemory* memory) {
  memory->Clear();
  switch (message.request_case()) {
    case v1::RunPoolRequest::kStep:
      return ReadStep(message.step(), memory);
    case v1::RunPoolRequest::kReset:
      return ReadReset(message.reset(), memory);
    case v1::RunPoolRequest::kObserve:
      return ReadObserve(message.observe(), memory);
    case v1::RunPoolRequest::kLevelSampler:
      return ReadSampler(message.level_sampler(), memory);
    default:
      return absl::InvalidArgumentError(
          "the request is empty, allowed: start, step, reset, observe, save_states, "
          "restore_states, clone_states, level_sampler or render");
  }
}

absl::Status CheckResponseFits(const Request& request, Encoding encoding, int64_t observation_bytes,
                               int64_t response_bytes_max) {
  const int64_t row_bytes =
      kRowNumberBytes +
      (request.with_observations ? EncodedBytesMax(encoding, observation_bytes) : 0) +
      (request.with_final_observations ? observation_bytes : 0);
  const int64_t rows_max = (response_bytes_max - kResponseOverheadBytes) / row_bytes;
  if (request.acknowledge_only || request.count <= rows_max) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(absl::StrCat(
      "slice.env_count is ", request.count, ", limit response_bytes_max is ", response_bytes_max,
      ", which has room for ", rows_max, " environments of ", observation_bytes, " bytes"));
}

}  // namespace procgen
