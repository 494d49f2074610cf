#ifndef SERVER_DM_ENV_RPC_WORLD_SPECS_H_
#define SERVER_DM_ENV_RPC_WORLD_SPECS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "server/dm_env_rpc/tensor.h"
#include "server/session/pool/pool_session.h"

namespace procgen {

// The numbers of what a world takes and tells. They are told in README.md and never change.
inline constexpr uint64_t kActionUid = 1;
enum class ObservationUid : uint64_t {
  kRgb = 1,
  kReward = 2,
  kLevelSeed = 3,
  kPrevLevelSeed = 4,
  kPrevLevelComplete = 5,
  kEpisodeReturn = 6,
  kEpisodeLength = 7,
  kFingerprint = 8,
  // Of a batch; a single environment tells them by its state.
  kFirst = 9,
  kTerminated = 10,
  kTruncated = 11,
};

// What of a pool decides how its world looks.
struct WorldForm {
  static WorldForm Of(const PoolSession& pool);

  // Of one value for each environment.
  TensorShape shape() const {
    return is_single ? TensorShape::Scalar() : TensorShape::List(env_count);
  }
  int32_t action_min() const { return is_single ? 0 : kEndEpisodeAction; }

  // One environment whose episodes end by the protocol's states; otherwise a batch.
  bool is_single = false;
  int32_t env_count = 0;
  std::vector<int32_t> frame_shape;  // of one environment's observation
  size_t frame_bytes = 0;            // of it
};

// What the world takes and tells.
dm::ActionObservationSpecs SpecsOf(const WorldForm& form);

// The actions of a step, one for each environment; without any, all do nothing. Errors:
// INVALID_ARGUMENT a number that is no action's, another type or shape, an action out of range.
absl::StatusOr<std::vector<int32_t>> ReadActions(const WorldForm& form,
                                                 const dm::StepRequest& request);

// All of the requested observations are there, and fit a response. Errors: INVALID_ARGUMENT there
// is none of that number (the message names it); RESOURCE_EXHAUSTED they are larger than a
// response.
absl::Status CheckRequestedObservations(const WorldForm& form, const dm::StepRequest& request,
                                        int64_t response_bytes_max);

// Whether a request asks for pictures.
bool RequestsFrames(const dm::StepRequest& request);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_WORLD_SPECS_H_
