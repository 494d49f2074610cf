#include "server/dm_env_rpc/world_specs.h"

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace procgen {
namespace {

// Bytes of a response besides the pictures, for each environment: what all other observations take.
constexpr int64_t kRowBytes = 64;

struct ObservationFacts {
  ObservationUid uid;
  const char* name;
  dm::DataType type;
  bool of_batches;  // only of these
};

constexpr ObservationFacts kObservations[] = {
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

bool Tells(const WorldForm& form, const ObservationFacts& facts) {
  return !form.is_single || !facts.of_batches;
}

dm::TensorSpec SpecOf(const WorldForm& form, const char* name, dm::DataType type) {
  dm::TensorSpec spec;
  spec.set_name(name);
  spec.set_dtype(type);
  if (!form.is_single) {
    spec.add_shape(form.env_count);
  }
  return spec;
}

}  // namespace

WorldForm WorldForm::Of(const PoolSession& pool) {
  WorldForm form;
  form.env_count = pool.env_count();
  form.is_single = form.env_count == 1 && pool.options().autoreset_mode == AutoresetMode::kDisabled;
  form.frame_shape = pool.options().observation_format.Shape();
  form.frame_bytes = pool.options().observation_format.bytes();
  return form;
}

dm::ActionObservationSpecs SpecsOf(const WorldForm& form) {
  dm::ActionObservationSpecs specs;
  dm::TensorSpec action = SpecOf(form, "action", dm::INT32);
  action.mutable_min()->mutable_int32s()->add_array(form.action_min());
  action.mutable_max()->mutable_int32s()->add_array(kActionCount - 1);
  (*specs.mutable_actions())[kActionUid] = std::move(action);
  for (const ObservationFacts& facts : kObservations) {
    if (!Tells(form, facts)) {
      continue;
    }
    dm::TensorSpec spec = SpecOf(form, facts.name, facts.type);
    if (facts.uid == ObservationUid::kRgb) {
      spec.mutable_shape()->Add(form.frame_shape.begin(), form.frame_shape.end());
      spec.mutable_min()->mutable_uint8s()->set_array(std::string(1, '\x00'));
      spec.mutable_max()->mutable_uint8s()->set_array(std::string(1, '\xff'));
    }
    (*specs.mutable_observations())[static_cast<uint64_t>(facts.uid)] = std::move(spec);
  }
  return specs;
}

absl::StatusOr<std::vector<int32_t>> ReadActions(const WorldForm& form,
                                                 const dm::StepRequest& request) {
  for (const auto& [uid, tensor] : request.actions()) {
    if (uid != kActionUid) {
      return absl::InvalidArgumentError(
          absl::StrCat("there is no action ", uid, ", allowed: ", kActionUid));
    }
  }
  const auto given = request.actions().find(kActionUid);
  if (given == request.actions().end()) {
    return std::vector<int32_t>(static_cast<size_t>(form.env_count), kNoAction);
  }
  absl::StatusOr<std::vector<int32_t>> actions =
      ReadInt32s(absl::StrCat("action ", kActionUid), given->second, form.shape());
  if (!actions.ok()) {
    return actions;
  }
  for (size_t i = 0; i < actions->size(); ++i) {
    const int32_t action = (*actions)[i];
    if (action < form.action_min() || action >= kActionCount) {
      return absl::InvalidArgumentError(
          absl::StrCat("action ", kActionUid, " is ", action,
                       form.is_single ? "" : absl::StrCat(" for environment ", i),
                       ", allowed: ", form.action_min(), " to ", kActionCount - 1));
    }
  }
  return actions;
}

absl::Status CheckRequestedObservations(const WorldForm& form, const dm::StepRequest& request,
                                        int64_t response_bytes_max) {
  for (const uint64_t uid : request.requested_observations()) {
    const bool told = std::any_of(
        std::begin(kObservations), std::end(kObservations), [&](const ObservationFacts& facts) {
          return static_cast<uint64_t>(facts.uid) == uid && Tells(form, facts);
        });
    if (!told) {
      const ObservationUid last =
          form.is_single ? ObservationUid::kFingerprint : ObservationUid::kTruncated;
      return absl::InvalidArgumentError(absl::StrCat(
          "there is no observation ", uid, ", allowed: 1 to ", static_cast<uint64_t>(last)));
    }
  }
  const int64_t frame_bytes = RequestsFrames(request) ? static_cast<int64_t>(form.frame_bytes) : 0;
  const int64_t bytes = form.env_count * (frame_bytes + kRowBytes);
  if (bytes > response_bytes_max) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the requested observations of ", form.env_count, " environments take ", bytes,
                     " bytes, limit response_bytes_max is ", response_bytes_max));
  }
  return absl::OkStatus();
}

bool RequestsFrames(const dm::StepRequest& request) {
  return std::find(request.requested_observations().begin(), request.requested_observations().end(),
                   static_cast<uint64_t>(ObservationUid::kRgb)) !=
         request.requested_observations().end();
}

}  // namespace procgen
