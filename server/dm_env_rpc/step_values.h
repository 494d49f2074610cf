#ifndef SERVER_DM_ENV_RPC_STEP_VALUES_H_
#define SERVER_DM_ENV_RPC_STEP_VALUES_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

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

  bool first(size_t environment) const { return first_[environment] != 0; }
  bool terminated(size_t environment) const { return terminated_[environment] != 0; }
  bool truncated(size_t environment) const { return truncated_[environment] != 0; }
  int32_t level_seed(size_t environment) const { return level_seeds_[environment]; }
  const std::vector<int32_t>& level_seeds() const { return level_seeds_; }

  // Tells what is requested but the pictures, which are in the response already. REQUIRES:
  // CheckRequestedObservations.
  void Fill(const WorldForm& form, const dm::StepRequest& request,
            dm::StepResponse* response) const;

 private:
  // All [N].
  std::vector<float> rewards_;
  std::vector<uint8_t> first_;
  std::vector<uint8_t> terminated_;
  std::vector<uint8_t> truncated_;
  std::vector<int32_t> level_seeds_;
  std::vector<int32_t> prev_level_seeds_;
  std::vector<uint8_t> prev_level_complete_;
  std::vector<float> episode_returns_;
  std::vector<int32_t> episode_lengths_;
  std::vector<uint64_t> fingerprints_;
};

// Puts memory for the pictures into the response, if they are requested; empty: they are not.
absl::Span<uint8_t> AddFrames(const WorldForm& form, const dm::StepRequest& request,
                              dm::StepResponse* response);

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_STEP_VALUES_H_
