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

// What the environments of a world told last, and how it is told on.
class StepValues {
 public:
  StepValues() = default;
  explicit StepValues(const WorldForm& form);

  // Where the next step writes it; `frames`: where it draws, [N, F], or empty.
  Batch BatchOf(absl::Span<uint8_t> frames);

  // Makes it that of a step that took no action: nothing gained, nothing ended.
  void ForgetOutcome();

  bool first(size_t environment) const { return numbers_.first[environment] != 0; }
  bool terminated(size_t environment) const { return numbers_.terminated[environment] != 0; }
  bool truncated(size_t environment) const { return numbers_.truncated[environment] != 0; }
  int32_t level_seed(size_t environment) const { return numbers_.level_seeds[environment]; }
  const std::vector<int32_t>& level_seeds() const { return numbers_.level_seeds; }

  // Tells what is requested but the pictures, which are in the response already. REQUIRES:
  // CheckRequestedObservations.
  void Fill(const WorldForm& form, const dm::StepRequest& request,
            dm::StepResponse* response) const;

 private:
  int32_t env_count_ = 0;
  BatchNumbers numbers_;  // [N]
};

// Puts memory for the pictures into the response, if they are requested; empty: they are not.
absl::Span<uint8_t> AddFrames(const WorldForm& form, const dm::StepRequest& request,
                              dm::StepResponse* response);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_STEP_VALUES_H_
