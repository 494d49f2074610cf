#ifndef SERVER_DM_ENV_RPC_WORLD_SPECS_H_
#define SERVER_DM_ENV_RPC_WORLD_SPECS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "server/dm_env_rpc/tensor.h"
#include "server/session/pool/pool_session.h"

namespace procgen {

// Numbers of a world's action and observations, documented in README.md. They never change.
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
  // Only in batches; for a single environment the state of the response has them.
  kFirst = 9,
  kTerminated = 10,
  kTruncated = 11,
};

// The properties of a pool that determine its world's action and observation specs.
struct WorldSignature {
  static WorldSignature Of(const PoolSession& pool);

  // Shape of a tensor with one value per environment.
  TensorShape shape() const {
    return is_single ? TensorShape::Scalar() : TensorShape::List(env_count);
  }
  int32_t action_min() const { return is_single ? 0 : kEndEpisodeAction; }

  // Whether the world is one environment without autoreset; otherwise it is a batch.
  bool is_single = false;
  int32_t env_count = 0;
  std::vector<int32_t> frame_shape;  // of one environment's picture
  size_t frame_bytes = 0;            // of one environment's picture
};

// The specs of the world's action and observations.
dm::ActionObservationSpecs SpecsOf(const WorldSignature& signature);

// Returns the actions of a step [N]; kNoAction for all if the request has none.
// Errors: INVALID_ARGUMENT unknown action number, wrong type or shape, or an action out of range.
absl::StatusOr<std::vector<int32_t>> ReadActions(const WorldSignature& signature,
                                                 const dm::StepRequest& request);

// Checks that the requested observations exist and fit in a response.
// Errors: INVALID_ARGUMENT an unknown number (the message has it); RESOURCE_EXHAUSTED they are
// larger than `response_bytes_max`.
absl::Status CheckRequestedObservations(const WorldSignature& signature,
                                        const dm::StepRequest& request, int64_t response_bytes_max);

// Whether the request contains observation kRgb.
bool RequestsFrames(const dm::StepRequest& request);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_WORLD_SPECS_H_
