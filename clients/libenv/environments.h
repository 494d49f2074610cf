#ifndef CLIENTS_LIBENV_ENVIRONMENTS_H_
#define CLIENTS_LIBENV_ENVIRONMENTS_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// How N environments stand. Good until the next call on the environments.
struct Observed {
  absl::Span<const uint8_t> observations;         // [N, 64, 64, 3]
  absl::Span<const float> rewards;                // [N]
  absl::Span<const uint8_t> first;                // [N]
  absl::Span<const int32_t> prev_level_seeds;     // [N]
  absl::Span<const uint8_t> prev_level_complete;  // [N]
  absl::Span<const int32_t> level_seeds;          // [N]
};

// The environments behind a handle, wherever they are; at first they stand at the first step of
// their first levels. Ending them waits for a step that runs.
// Threads: compatible (one at a time).
class Environments {
 public:
  virtual ~Environments() = default;

  // Begins a step and may return before it is done. `actions`: [N], each in [-1, kActionCount);
  // needed during the call only. Errors: those of the step before, or of this one, as far as they
  // are known.
  virtual absl::Status Act(absl::Span<const int32_t> actions) = 0;

  // Waits for the step.
  virtual absl::StatusOr<Observed> Observe() = 0;

  // Waits for the step and draws the human view of one environment. `frame`: uint8
  // [kHumanViewSizePx, kHumanViewSizePx, 3].
  virtual absl::Status Render(int32_t environment, absl::Span<uint8_t> frame) = 0;

  // Waits for the step and takes a snapshot of one environment.
  virtual absl::StatusOr<std::string> SaveState(int32_t environment) = 0;

  // Waits for the step and puts one environment into a saved state, which the next Observe tells.
  // On error nothing has changed. Errors: INVALID_ARGUMENT a snapshot of another game, or with a
  // value out of range; DATA_LOSS one that is damaged or of another version.
  virtual absl::Status RestoreState(int32_t environment, absl::string_view snapshot) = 0;
};

}  // namespace procgen

#endif  // CLIENTS_LIBENV_ENVIRONMENTS_H_
