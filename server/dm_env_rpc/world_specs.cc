#include "server/dm_env_rpc/world_specs.h"

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace procgen {
namespace {

// Upper bound of the size of an environment's observations other than the picture, in bytes.
constexpr int64_t kRowBytes = 64;

struct ObservationInfo {
  ObservationUid uid;
  const char* name;
  dm::DataType type;
  bool of_batches;  // only in batches
};

constexpr ObservationInfo kObservations[] = {
    {ObservationUid::kRgb, "rgb", dm::UINT8, false},
    {ObservationUid::kReward, "reward", dm::FLOAT, false},
    {ObservationUid::kLevelSeed, "level_seed", dm::INT32, false},
    {ObservationUid::kPrevLevelSeed, "prev_level_seed", dm::INT32, false},
    {ObservationUid::kPrevLevelComplete, "prev_level_complete", dm::BOOL, false},
    {ObservationUid::kEpisodeReturn, "episode_return", dm::FLOAT, false},
    {ObservationUid::kEpisodeLength, "episode_length", dm::INT32, false},
    {ObservationUid::kFingerprint, "fingerprint", dm::UINT64, false},
    {ObservationUid::kFirst, "first", dm::BOOL, true},
    {ObservationUid::kTerminated, "terminated", dm::BOOL, true},
    {ObservationUid::kTruncated, "truncated", dm::BOOL, true},
};

bool HasObservation(const WorldSignature& signature, const ObservationInfo& info) {
  return !signature.is_single || !info.of_batches;
}

dm::TensorSpec SpecOf(const WorldSignature& signature, const char* name, dm::DataType type) {
  dm::TensorSpec spec;
  spec.set_name(name);
  spec.set_dtype(type);
  if (!signature.is_single) {
    spec.add_shape(signature.env_count);
  }
  return spec;
}

}  // namespace

WorldSignature WorldSignature::Of(const PoolSession& pool) {
  WorldSignature signature;
  signature.env_count = pool.env_count();
  signature.is_single =
      signature.env_count == 1 && pool.options().autoreset_mode == AutoresetMode::kDisabled;
  signature.frame_shape = pool.options().observation_format.Shape();
  signature.frame_bytes = pool.options().observation_format.bytes();
  return signature;
}

dm::ActionObservationSpecs SpecsOf(const WorldSignature& signature) {
  dm::ActionObservationSpecs specs;
  dm::TensorSpec action = SpecOf(signature, "action", dm::INT32);
  action.mutable_min()->mutable_int32s()->add_array(signature.action_min());
  action.mutable_max()->mutable_int32s()->add_array(kActionCount - 1);
  (*specs.mutable_actions())[kActionUid] = std::move(action);
  for (const ObservationInfo& info : kObservations) {
    if (!HasObservation(signature, info)) {
      continue;
    }
    dm::TensorSpec spec = SpecOf(signature, info.name, info.type);
    if (info.uid == ObservationUid::kRgb) {
      spec.mutable_shape()->Add(signature.frame_shape.begin(), signature.frame_shape.end());
      spec.mutable_min()->mutable_uint8s()->set_array(std::string(1, '\x00'));
      spec.mutable_max()->mutable_uint8s()->set_array(std::string(1, '\xff'));
    }
    (*specs.mutable_observations())[static_cast<uint64_t>(info.uid)] = std::move(spec);
  }
  return specs;
}

absl::StatusOr<std::vector<int32_t>> ReadActions(const WorldSignature& signature,
                                                 const dm::StepRequest& request) {
  for (const auto& [uid, tensor] : request.actions()) {
    if (uid != kActionUid) {
      return absl::InvalidArgumentError(
          absl::StrCat("there is no action ", uid, ", allowed: ", kActionUid));
    }
  }
  const auto given = request.actions().find(kActionUid);
  if (given == request.actions().end()) {
    return std::vector<int32_t>(static_cast<size_t>(signature.env_count), kNoAction);
  }
  absl::StatusOr<std::vector<int32_t>> actions =
      ReadInt32s(absl::StrCat("action ", kActionUid), given->second, signature.shape());
  if (!actions.ok()) {
    return actions;
  }
  for (size_t i = 0; i < actions->size(); ++i) {
    const int32_t action = (*actions)[i];
    if (action < signature.action_min() || action >= kActionCount) {
      return absl::InvalidArgumentError(
          absl::StrCat("action ", kActionUid, " is ", action,
                       signature.is_single ? "" : absl::StrCat(" for environment ", i),
                       ", allowed: ", signature.action_min(), " to ", kActionCount - 1));
    }
  }
  return actions;
}

absl::Status CheckRequestedObservations(const WorldSignature& signature,
                                        const dm::StepRequest& request,
                                        int64_t response_bytes_max) {
  for (const uint64_t uid : request.requested_observations()) {
    const bool exists = std::any_of(
        std::begin(kObservations), std::end(kObservations), [&](const ObservationInfo& info) {
          return static_cast<uint64_t>(info.uid) == uid && HasObservation(signature, info);
        });
    if (!exists) {
      const ObservationUid last =
          signature.is_single ? ObservationUid::kFingerprint : ObservationUid::kTruncated;
      return absl::InvalidArgumentError(absl::StrCat(
          "there is no observation ", uid, ", allowed: 1 to ", static_cast<uint64_t>(last)));
    }
  }
  const int64_t frame_bytes =
      RequestsFrames(request) ? static_cast<int64_t>(signature.frame_bytes) : 0;
  const int64_t bytes = signature.env_count * (frame_bytes + kRowBytes);
  if (bytes > response_bytes_max) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the requested observations of ", signature.env_count, " environments take ",
                     bytes, " bytes, limit response_bytes_max is ", response_bytes_max));
  }
  return absl::OkStatus();
}

bool RequestsFrames(const dm::StepRequest& request) {
  return std::find(request.requested_observations().begin(), request.requested_observations().end(),
                   static_cast<uint64_t>(ObservationUid::kRgb)) !=
         request.requested_observations().end();
}

}  // namespace procgen
