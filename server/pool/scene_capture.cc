#include "server/pool/scene_capture.h"

#include <cstddef>
#include <map>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// A free list of renderers, so that their memory is reused. Threads: any method from any thread.
class SceneCapture::Renderers {
 public:
  std::unique_ptr<SceneSnapshotRenderer> Take() {
    {
      absl::MutexLock lock(&mutex_);
      if (idle_ != nullptr) {
        return std::move(idle_);
      }
    }
    return std::make_unique<SceneSnapshotRenderer>();
  }
  void PutBack(std::unique_ptr<SceneSnapshotRenderer> renderer) {
    absl::MutexLock lock(&mutex_);
    idle_.swap(renderer);
  }

 private:
  absl::Mutex mutex_;
  std::unique_ptr<SceneSnapshotRenderer> idle_ ABSL_GUARDED_BY(mutex_);
};

SceneCapture::SceneCapture() : renderers_(std::make_shared<Renderers>()) {}

absl::StatusOr<Draw> SceneCapture::Capture(Pool* pool, absl::Span<const int32_t> environments,
                                           View view, int32_t size_px) {
  std::vector<SceneSnapshot> scenes;
  std::map<int32_t, size_t> places;  // in scenes, by environment
  std::vector<size_t> shown;         // places in the order of `environments`
  for (const int32_t environment : environments) {
    const auto [place, is_another] = places.emplace(environment, scenes.size());
    shown.push_back(place->second);
    if (!is_another) {
      continue;
    }
    absl::StatusOr<SceneSnapshot> scene =
        pool->CaptureScene(environment, /*whole_level=*/view == View::kLevel);
    if (!scene.ok()) {
      return scene.status();
    }
    scenes.push_back(*std::move(scene));
  }
  return Draw([scenes = std::move(scenes), shown = std::move(shown), view, size_px,
               renderers = renderers_](const std::vector<absl::Span<uint8_t>>& frames) {
    std::unique_ptr<SceneSnapshotRenderer> renderer = renderers->Take();
    for (size_t i = 0; i < frames.size(); ++i) {
      const SceneSnapshot& scene = scenes[shown[i % shown.size()]];
      if (view == View::kAgent || i >= shown.size()) {
        renderer->DrawAgentView(scene, frames[i]);
      } else {
        renderer->DrawHumanView(scene, size_px, frames[i]);
      }
    }
    renderers->PutBack(std::move(renderer));
  });
}

}  // namespace procgen
