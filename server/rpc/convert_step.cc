#include "server/rpc/convert_step.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/rpc/convert_pool.h"

namespace procgen {
namespace {

// Bytes of the numbers of a row in a response, at most: five of four bytes (rewards, level_seeds,
// prev_level_seeds, episode_returns, episode_lengths), four flags and a fingerprint.
constexpr int64_t kRowNumberBytes = 5 * 4 + 4 + 8;
// All that a response has besides its rows: tags and lengths, at most, rounded up.
constexpr int64_t kResponseOverheadBytes = 256;
constexpr int32_t kResponseCountMinMax = 64;

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
  request->first = slice.first_environment();
  request->count = slice.environment_count();
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
  request->request.with_final_observations = step.with_final_observations();
  if (step.response_count_min() < 0 || step.response_count_min() > kResponseCountMinMax) {
    return absl::InvalidArgumentError(absl::StrCat("response_count_min is ",
                                                   step.response_count_min(), ", allowed: 0 to ",
                                                   kResponseCountMinMax));
  }
  request->request.chunk_count = std::max(step.response_count_min(), 1);
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

// Memory for `count` numbers of an array.
template <typename Number>
absl::Span<Number> Sized(google::protobuf::RepeatedField<Number>* array, int32_t count) {
  array->Resize(count, Number());
  return absl::MakeSpan(array->mutable_data(), static_cast<size_t>(count));
}

absl::Span<uint8_t> Sized(google::protobuf::RepeatedField<bool>* array, int32_t count) {
  static_assert(sizeof(bool) == 1);
  array->Resize(count, false);
  return absl::MakeSpan(reinterpret_cast<uint8_t*>(array->mutable_data()),
                        static_cast<size_t>(count));
}

// The bits of unsigned numbers, in an array of signed ones.
absl::Span<uint64_t> SizedBits(google::protobuf::RepeatedField<int64_t>* array, int32_t count) {
  const absl::Span<int64_t> numbers = Sized(array, count);
  return absl::MakeSpan(reinterpret_cast<uint64_t*>(numbers.data()), numbers.size());
}

absl::Span<uint8_t> Sized(std::string* bytes, int64_t size) {
  bytes->resize(static_cast<size_t>(size));
  return absl::MakeSpan(reinterpret_cast<uint8_t*>(bytes->data()), bytes->size());
}

}  // namespace

absl::Status ReadStreamRequest(StreamRequest* request) {
  const v1::StepPoolRequest& message = request->message;
  request->next_levels.clear();
  request->resets.clear();
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
      "the request asks for nothing, allowed: step, reset, observe or level_sampler");
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

Batch PrepareResponse(const Request& request, Part part, int64_t observation_bytes,
                      FrameRing* frames, Response* response) {
  response->message.set_sequence_number(request.sequence_number);
  if (request.kind == Request::Kind::kSample) {
    response->message.mutable_done();
    return {};
  }
  const int64_t picture_bytes = part.count * observation_bytes;
  const int32_t slice_end = request.first + request.count;
  v1::Batch* message = response->message.mutable_batch();
  message->set_first_environment(part.first);
  message->set_environment_count(part.count);
  message->set_last(part.first + part.count == slice_end);
  Batch batch;
  batch.rewards = Sized(message->mutable_rewards(), part.count);
  batch.first = Sized(message->mutable_first(), part.count);
  batch.terminated = Sized(message->mutable_terminated(), part.count);
  batch.truncated = Sized(message->mutable_truncated(), part.count);
  batch.level_seeds = Sized(message->mutable_level_seeds(), part.count);
  batch.prev_level_seeds = Sized(message->mutable_prev_level_seeds(), part.count);
  batch.prev_level_complete = Sized(message->mutable_prev_level_complete(), part.count);
  batch.episode_returns = Sized(message->mutable_episode_returns(), part.count);
  batch.episode_lengths = Sized(message->mutable_episode_lengths(), part.count);
  batch.fingerprints = SizedBits(message->mutable_fingerprints(), part.count);
  batch.final_observations = Sized(message->mutable_final_observations(),
                                   request.with_final_observations ? picture_bytes : 0);
  response->observations = grpc::Slice();  // goes back to `frames` before another is taken
  Frames observations =
      frames->Take(static_cast<size_t>(request.with_observations ? picture_bytes : 0));
  batch.observations = observations.bytes;
  response->observations = std::move(observations.slice);
  return batch;
}

void CompleteResponse(int64_t observation_bytes, const Batch& batch,
                      v1::StepPoolResponse* response) {
  const auto picture_bytes = static_cast<size_t>(observation_bytes);
  uint8_t* const pictures = batch.final_observations.data();
  const bool has_pictures = !batch.final_observations.empty();
  size_t kept = 0;
  for (size_t row = 0; row < batch.terminated.size(); ++row) {
    if (batch.terminated[row] == 0 && batch.truncated[row] == 0) {
      continue;
    }
    batch.fingerprints[kept] = batch.fingerprints[row];
    if (has_pictures && row != kept) {
      std::memcpy(pictures + kept * picture_bytes, pictures + row * picture_bytes, picture_bytes);
    }
    ++kept;
  }
  if (response->has_batch() && !response->batch().has_shared_batch()) {
    v1::Batch* message = response->mutable_batch();
    message->mutable_fingerprints()->Truncate(static_cast<int>(kept));
    message->mutable_final_observations()->resize(has_pictures ? kept * picture_bytes : 0);
  }
}

}  // namespace procgen
