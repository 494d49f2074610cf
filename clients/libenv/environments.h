#ifndef CLIENTS_LIBENV_ENVIRONMENTS_H_
#define CLIENTS_LIBENV_ENVIRONMENTS_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// Values of N environments. Valid until the next call on the environments.
struct EnvironmentValues {
  absl::Span<const uint8_t> observations;         // [N, 64, 64, 3]
  absl::Span<const float> rewards;                // [N]
  absl::Span<const uint8_t> first;                // [N]
  absl::Span<const int32_t> prev_level_seeds;     // [N]
  absl::Span<const uint8_t> prev_level_complete;  // [N]
  absl::Span<const int32_t> level_seeds;          // [N]
};

// The environments behind a handle, in this process or on a server. Initially each is at the first
// step of its first level. The destructor waits for a running step.
// Threads: compatible (one at a time).
class Environments {
 public:
  virtual ~Environments() = default;

  // Starts a step and may return before it is done. `actions`: [N], each in [-1, kActionCount),
  // not used after the call. Errors: those of the previous step, and those of this one that are
  // known already.
  virtual absl::Status Act(absl::Span<const int32_t> actions) = 0;

  // Waits for the step and returns its values.
  virtual absl::StatusOr<EnvironmentValues> Observe() = 0;

  // Waits for the step and renders the human view of one environment. `frame`: uint8
  // [kHumanViewSizePx, kHumanViewSizePx, 3].
  virtual absl::Status Render(int32_t environment, absl::Span<uint8_t> frame) = 0;

  // Waits for the step and returns a snapshot of one environment.
  virtual absl::StatusOr<std::string> SaveState(int32_t environment) = 0;

  // Waits for the step and restores a snapshot in one environment; the next Observe returns it. On
  // error nothing has changed. Errors: INVALID_ARGUMENT a snapshot of another game, or with a value
  // out of range; DATA_LOSS a snapshot that is damaged or of another version.
  virtual absl::Status RestoreState(int32_t environment, absl::string_view snapshot) = 0;
};

}  // namespace procgen

#endif  // CLIENTS_LIBENV_ENVIRONMENTS_H_
