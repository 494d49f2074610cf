#include "server/dm_env_rpc/step_values.h"

#include <algorithm>

namespace procgen {
namespace {

template <typename Array, typename Element>
void Assign(const std::vector<Element>& values, Array* array) {
  array->mutable_array()->Assign(values.begin(), values.end());
}

}  // namespace

StepValues::StepValues(const WorldForm& form) {
  const auto count = static_cast<size_t>(form.env_count);
  rewards_.resize(count);
  first_.resize(count);
  terminated_.resize(count);
  truncated_.resize(count);
  level_seeds_.resize(count);
  prev_level_seeds_.resize(count);
  prev_level_complete_.resize(count);
  episode_returns_.resize(count);
  episode_lengths_.resize(count);
  fingerprints_.resize(count);
}

Batch StepValues::BatchOf(absl::Span<uint8_t> frames) {
  Batch batch;
  batch.observations = frames;
  batch.rewards = absl::MakeSpan(rewards_);
  batch.first = absl::MakeSpan(first_);
  batch.terminated = absl::MakeSpan(terminated_);
  batch.truncated = absl::MakeSpan(truncated_);
  batch.level_seeds = absl::MakeSpan(level_seeds_);
  batch.prev_level_seeds = absl::MakeSpan(prev_level_seeds_);
  batch.prev_level_complete = absl::MakeSpan(prev_level_complete_);
  batch.episode_returns = absl::MakeSpan(episode_returns_);
  batch.episode_lengths = absl::MakeSpan(episode_lengths_);
  batch.fingerprints = absl::MakeSpan(fingerprints_);
  return batch;
}

void StepValues::ForgetOutcome() {
  std::fill(rewards_.begin(), rewards_.end(), 0.0F);
  std::fill(terminated_.begin(), terminated_.end(), 0);
  std::fill(truncated_.begin(), truncated_.end(), 0);
}

void StepValues::Fill(const WorldForm& form, const dm::StepRequest& request,
                      dm::StepResponse* response) const {
  for (const uint64_t uid : request.requested_observations()) {
    dm::Tensor& tensor = (*response->mutable_observations())[uid];
    tensor.clear_shape();  // of one that is requested twice
    if (!form.is_single) {
      tensor.add_shape(form.env_count);
    }
    switch (static_cast<ObservationUid>(uid)) {
      case ObservationUid::kRgb:
        tensor.mutable_shape()->Add(form.frame_shape.begin(), form.frame_shape.end());
        break;
      case ObservationUid::kReward:
        Assign(rewards_, tensor.mutable_floats());
        break;
      case ObservationUid::kLevelSeed:
        Assign(level_seeds_, tensor.mutable_int32s());
        break;
      case ObservationUid::kPrevLevelSeed:
        Assign(prev_level_seeds_, tensor.mutable_int32s());
        break;
      case ObservationUid::kPrevLevelComplete:
        Assign(prev_level_complete_, tensor.mutable_bools());
        break;
      case ObservationUid::kEpisodeReturn:
        Assign(episode_returns_, tensor.mutable_floats());
        break;
      case ObservationUid::kEpisodeLength:
        Assign(episode_lengths_, tensor.mutable_int32s());
        break;
      case ObservationUid::kFingerprint:
        Assign(fingerprints_, tensor.mutable_uint64s());
        break;
      case ObservationUid::kFirst:
        Assign(first_, tensor.mutable_bools());
        break;
      case ObservationUid::kTerminated:
        Assign(terminated_, tensor.mutable_bools());
        break;
      case ObservationUid::kTruncated:
        Assign(truncated_, tensor.mutable_bools());
        break;
    }
  }
}

absl::Span<uint8_t> AddFrames(const WorldForm& form, const dm::StepRequest& request,
                              dm::StepResponse* response) {
  if (!RequestsFrames(request)) {
    return {};
  }
  dm::Tensor& tensor =
      (*response->mutable_observations())[static_cast<uint64_t>(ObservationUid::kRgb)];
  std::string* bytes = tensor.mutable_uint8s()->mutable_array();
  bytes->resize(form.frame_bytes * static_cast<size_t>(form.env_count));
  return {reinterpret_cast<uint8_t*>(bytes->data()), bytes->size()};
}

}  // namespace procgen
