#include "envcore/pool/scene_snapshot.h"

#include <utility>

#include "envcore/environment/environment.h"
#include "envcore/level/generated_art.h"
#include "envcore/render/scene/rasteriser.h"
#include "envcore/scene/scene.h"
#include "envcore/world/grid.h"

namespace procgen {

// A scene and copies of what it points to.
struct SceneSnapshot::Content {
  Scene scene;
  Grid grid;
  GeneratedArt background;
  std::shared_ptr<const GameArt> art;
};

SceneSnapshot::SceneSnapshot(std::shared_ptr<const GameArt> art)
    : content_(std::make_unique<Content>()) {
  content_->art = std::move(art);
}

SceneSnapshot::SceneSnapshot(const Environment& environment, std::shared_ptr<const GameArt> art)
    : SceneSnapshot(std::move(art)) {
  environment.FillScene(&content_->scene);
  CopyReferences();
}

SceneSnapshot SceneSnapshot::OfLevel(Environment* environment, std::shared_ptr<const GameArt> art) {
  SceneSnapshot snapshot(std::move(art));
  environment->FillLevelScene(&snapshot.content_->scene);
  snapshot.CopyReferences();
  return snapshot;
}

void SceneSnapshot::CopyReferences() {
  Scene& scene = content_->scene;
  if (scene.cells.grid != nullptr) {
    content_->grid = *scene.cells.grid;
    scene.cells.grid = &content_->grid;
  }
  if (scene.background.generated != nullptr) {
    content_->background = *scene.background.generated;
    scene.background.generated = &content_->background;
  }
}

SceneSnapshot::SceneSnapshot(SceneSnapshot&& other) noexcept = default;
SceneSnapshot& SceneSnapshot::operator=(SceneSnapshot&& other) noexcept = default;
SceneSnapshot::~SceneSnapshot() = default;

SceneSnapshotRenderer::SceneSnapshotRenderer() : rasteriser_(std::make_unique<Rasteriser>()) {}

SceneSnapshotRenderer::~SceneSnapshotRenderer() = default;

void SceneSnapshotRenderer::DrawHumanView(const SceneSnapshot& snapshot, int32_t size_px,
                                          absl::Span<uint8_t> frame) {
  rasteriser_->DrawHumanView(snapshot.content_->scene, *snapshot.content_->art, size_px, frame);
}

void SceneSnapshotRenderer::DrawAgentView(const SceneSnapshot& snapshot,
                                          absl::Span<uint8_t> frame) {
  rasteriser_->DrawAgentView(snapshot.content_->scene, *snapshot.content_->art, nullptr,
                             kUpstreamFrameFormat, frame);
}

}  // namespace procgen
