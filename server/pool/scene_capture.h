#ifndef SERVER_POOL_SCENE_CAPTURE_H_
#define SERVER_POOL_SCENE_CAPTURE_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"

namespace procgen {

// How an environment is drawn.
enum class View : uint8_t {
  kHuman,  // antialiased, as Pool::Render does
  kAgent,  // as an observation in the default format, and so at kObservationSizePx
  kLevel,  // as kHuman, with the whole level
};

// Draws captured scenes. Call once, on any thread; the pool may be busy or destroyed by then.
// `frames`: uint8 [size_px, size_px, 3], one for each captured environment. As many uint8
// [64, 64, 3] may follow, which get the agent's views.
using Draw = absl::AnyInvocable<void(const std::vector<absl::Span<uint8_t>>& frames)>;

// Captures the scenes of a pool's environments, to be drawn later: a few us for each.
class SceneCapture {
 public:
  SceneCapture();

  // `environments`: repeats allowed. REQUIRES: no step of the pool is in progress.
  // Errors: those of Pool::CaptureScene.
  absl::StatusOr<Draw> Capture(Pool* pool, absl::Span<const int32_t> environments, View view,
                               int32_t size_px);

 private:
  class Renderers;

  const std::shared_ptr<Renderers> renderers_;  // shared with what is drawn
};

}  // namespace procgen

#endif  // SERVER_POOL_SCENE_CAPTURE_H_
