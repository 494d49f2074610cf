#include "server/wire/convert_step.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/wire/convert_pool.h"

namespace procgen {
namespace {

// Upper bound of a row's numbers in a response, in bytes: five of four bytes (rewards, level_seeds,
// prev_level_seeds, episode_returns, episode_lengths), four flags and a fingerprint.
constexpr int64_t kRowNumberBytes = 5 * 4 + 4 + 8;
// Upper bound of the tags and lengths of a response, in bytes.
constexpr int64_t kResponseOverheadBytes = 256;
constexpr int32_t kChunkCountMax = 64;

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
                StreamRequest* request) {
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

absl::Status ReadStep(const v1::Step& step, StreamRequest* request) {
  request->request.kind = Request::Kind::kStep;
  ReadSlice(step.slice(), &request->request);
  request->request.actions =
      absl::MakeConstSpan(step.actions().data(), static_cast<size_t>(step.actions_size()));
  request->request.repeat = step.repeat_count() == 0 ? 1 : step.repeat_count();
  for (const v1::NextLevel& message : step.next_levels()) {
    request->next_levels.push_back({message.environment(), message.level_seed()});
  }
  request->request.next_levels = request->next_levels;
  ReadResets(step.resets(), request);
  for (const v1::Annotation& message : step.annotations()) {
    request->annotations.push_back(
        {message.name(),
         absl::MakeConstSpan(message.values().data(), static_cast<size_t>(message.values_size()))});
  }
  request->request.annotations = request->annotations;
  request->request.with_final_observations = step.with_final_observations();
  if (step.chunk_count() < 0 || step.chunk_count() > kChunkCountMax) {
    return absl::InvalidArgumentError(
        absl::StrCat("chunk_count is ", step.chunk_count(), ", allowed: 0 to ", kChunkCountMax));
  }
  request->request.chunk_count = std::max(step.chunk_count(), 1);
  return ReadObservation(step.observation(), &request->request);
}

absl::Status ReadSampler(const v1::LevelSampler& message, StreamRequest* request) {
  absl::StatusOr<std::shared_ptr<const LevelSampler>> sampler =
      LevelSamplerOf("level_sampler", message);
  if (!sampler.ok()) {
    return sampler.status();
  }
  request->request.kind = Request::Kind::kSample;
  request->request.level_sampler = *std::move(sampler);
  request->request.with_observations = false;
  return absl::OkStatus();
}

}  // namespace

absl::Status ReadStreamRequest(StreamRequest* request) {
  const v1::StepPoolRequest& message = request->message;
  request->next_levels.clear();
  request->resets.clear();
  request->annotations.clear();
  const absl::Time arrival_time = request->request.arrival_time;
  request->request = Request();
  request->request.arrival_time = arrival_time;
  request->request.sequence_number = message.sequence_number();
  request->request.acknowledged = message.acknowledged_sequence_number();
  request->request.released = absl::MakeConstSpan(
      message.released_batches().data(), static_cast<size_t>(message.released_batches_size()));
  switch (message.request_case()) {
    case v1::StepPoolRequest::kStep:
      return ReadStep(message.step(), request);
    case v1::StepPoolRequest::kReset:
      request->request.kind = Request::Kind::kReset;
      ReadSlice(message.reset().slice(), &request->request);
      ReadResets(message.reset().resets(), request);
      return ReadObservation(message.reset().observation(), &request->request);
    case v1::StepPoolRequest::kObserve:
      request->request.kind = Request::Kind::kObserve;
      ReadSlice(message.observe().slice(), &request->request);
      return ReadObservation(message.observe().observation(), &request->request);
    case v1::StepPoolRequest::kAttach:
      return absl::InvalidArgumentError(
          "attach was sent again, allowed: once, as the first request of a stream");
    case v1::StepPoolRequest::kLevelSampler:
      return ReadSampler(message.level_sampler(), request);
    case v1::StepPoolRequest::REQUEST_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError(
      "the request is empty, allowed: step, reset, observe or level_sampler");
}

absl::StatusOr<int32_t> ResponseRowsMax(absl::string_view limit, const Request& request,
                                        const ObservationCoding& coding,
                                        int64_t response_bytes_max) {
  const int observation_count =
      (request.with_observations ? 1 : 0) + (request.with_final_observations ? 1 : 0);
  const int64_t row_bytes = kRowNumberBytes +
                            (request.with_observations ? coding.sent_bytes_max() : 0) +
                            (request.with_final_observations ? coding.drawn_bytes() : 0);
  const int64_t rows = (response_bytes_max - kResponseOverheadBytes) / row_bytes;
  if (rows < 1) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "the answer for one environment has ", observation_count, " x ", coding.drawn_bytes(),
        " bytes of observations and needs ", row_bytes + kResponseOverheadBytes, ", limit ", limit,
        " is ", response_bytes_max));
  }
  return static_cast<int32_t>(std::min<int64_t>(rows, INT32_MAX));
}

}  // namespace procgen
