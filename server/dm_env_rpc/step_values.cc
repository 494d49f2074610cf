#include "server/dm_env_rpc/step_values.h"

#include <algorithm>

namespace procgen {
namespace {

template <typename Array, typename Element>
void Assign(const std::vector<Element>& values, Array* array) {
  array->mutable_array()->Assign(values.begin(), values.end());
}

}  // namespace

StepValues::StepValues(const WorldSignature& signature) : env_count_(signature.env_count) {
  numbers_.ReplaceEmptyArrays({}, env_count_);
}

Batch StepValues::BatchOf(absl::Span<uint8_t> frames) {
  Batch batch;
  batch.observations = frames;
  return numbers_.ReplaceEmptyArrays(batch, env_count_);
}

void StepValues::ClearOutcome() {
  std::fill(numbers_.rewards.begin(), numbers_.rewards.end(), 0.0F);
  std::fill(numbers_.terminated.begin(), numbers_.terminated.end(), 0);
  std::fill(numbers_.truncated.begin(), numbers_.truncated.end(), 0);
}

void StepValues::Fill(const WorldSignature& signature, const dm::StepRequest& request,
                      dm::StepResponse* response) const {
  for (const uint64_t uid : request.requested_observations()) {
    dm::Tensor& tensor = (*response->mutable_observations())[uid];
    tensor.clear_shape();  // an observation may be requested twice
    if (!signature.is_single) {
      tensor.add_shape(signature.env_count);
    }
    switch (static_cast<ObservationUid>(uid)) {
      case ObservationUid::kRgb:
        tensor.mutable_shape()->Add(signature.frame_shape.begin(), signature.frame_shape.end());
        break;
      case ObservationUid::kReward:
        Assign(numbers_.rewards, tensor.mutable_floats());
        break;
      case ObservationUid::kLevelSeed:
        Assign(numbers_.level_seeds, tensor.mutable_int32s());
        break;
      case ObservationUid::kPrevLevelSeed:
        Assign(numbers_.prev_level_seeds, tensor.mutable_int32s());
        break;
      case ObservationUid::kPrevLevelComplete:
        Assign(numbers_.prev_level_complete, tensor.mutable_bools());
        break;
      case ObservationUid::kEpisodeReturn:
        Assign(numbers_.episode_returns, tensor.mutable_floats());
        break;
      case ObservationUid::kEpisodeLength:
        Assign(numbers_.episode_lengths, tensor.mutable_int32s());
        break;
      case ObservationUid::kFingerprint:
        Assign(numbers_.fingerprints, tensor.mutable_uint64s());
        break;
      case ObservationUid::kFirst:
        Assign(numbers_.first, tensor.mutable_bools());
        break;
      case ObservationUid::kTerminated:
        Assign(numbers_.terminated, tensor.mutable_bools());
        break;
      case ObservationUid::kTruncated:
        Assign(numbers_.truncated, tensor.mutable_bools());
        break;
    }
  }
}

absl::Span<uint8_t> AddFrames(const WorldSignature& signature, const dm::StepRequest& request,
                              dm::StepResponse* response) {
  if (!RequestsFrames(request)) {
    return {};
  }
  dm::Tensor& tensor =
      (*response->mutable_observations())[static_cast<uint64_t>(ObservationUid::kRgb)];
  std::string* bytes = tensor.mutable_uint8s()->mutable_array();
  bytes->resize(signature.frame_bytes * static_cast<size_t>(signature.env_count));
  return {reinterpret_cast<uint8_t*>(bytes->data()), bytes->size()};
}

}  // namespace procgen
