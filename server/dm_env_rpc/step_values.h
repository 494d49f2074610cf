#ifndef SERVER_DM_ENV_RPC_STEP_VALUES_H_
#define SERVER_DM_ENV_RPC_STEP_VALUES_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "server/dm_env_rpc/world_specs.h"

namespace procgen {

// The latest results of a world's environments, and their conversion to tensors.
class StepValues {
 public:
  StepValues() = default;
  explicit StepValues(const WorldSignature& signature);

  // Returns the arrays that the next step writes. `frames`: memory for the pictures
  // [N, frame_bytes], or empty.
  Batch BatchOf(absl::Span<uint8_t> frames);

  // Clears rewards and episode ends, as for a step without actions.
  void ClearOutcome();

  bool first(size_t environment) const { return numbers_.first[environment] != 0; }
  bool terminated(size_t environment) const { return numbers_.terminated[environment] != 0; }
  bool truncated(size_t environment) const { return numbers_.truncated[environment] != 0; }
  int32_t level_seed(size_t environment) const { return numbers_.level_seeds[environment]; }
  const std::vector<int32_t>& level_seeds() const { return numbers_.level_seeds; }

  // Adds the requested observations to `response`. Of the pictures, which AddFrames added, it sets
  // only the shape. REQUIRES: CheckRequestedObservations returned OK.
  void Fill(const WorldSignature& signature, const dm::StepRequest& request,
            dm::StepResponse* response) const;

 private:
  int32_t env_count_ = 0;
  BatchNumbers numbers_;  // [N]
};

// Allocates the pictures in `response` and returns their memory; empty if they are not requested.
absl::Span<uint8_t> AddFrames(const WorldSignature& signature, const dm::StepRequest& request,
                              dm::StepResponse* response);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_STEP_VALUES_H_
