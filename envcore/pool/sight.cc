#include "envcore/pool/sight.h"

#include <utility>

#include "envcore/environment/environment.h"
#include "envcore/level/generated_art.h"
#include "envcore/render/scene/rasteriser.h"
#include "envcore/scene/scene.h"
#include "envcore/world/grid.h"

namespace procgen {

// A scene with what it refers to.
struct Sight::Content {
  Scene scene;
  Grid grid;
  GeneratedArt background;
  std::shared_ptr<const GameArt> art;
};

Sight::Sight(const Environment& environment, std::shared_ptr<const GameArt> art)
    : content_(std::make_unique<Content>()) {
  Scene& scene = content_->scene;
  environment.FillScene(&scene);
  if (scene.cells.grid != nullptr) {
    content_->grid = *scene.cells.grid;
    scene.cells.grid = &content_->grid;
  }
  if (scene.background.generated != nullptr) {
    content_->background = *scene.background.generated;
    scene.background.generated = &content_->background;
  }
  content_->art = std::move(art);
}

Sight::Sight(Sight&& other) noexcept = default;
Sight& Sight::operator=(Sight&& other) noexcept = default;
Sight::~Sight() = default;

SightPainter::SightPainter() : rasteriser_(std::make_unique<Rasteriser>()) {}

SightPainter::~SightPainter() = default;

void SightPainter::DrawHumanView(const Sight& sight, int32_t side_px, absl::Span<uint8_t> frame) {
  rasteriser_->DrawHumanView(sight.content_->scene, *sight.content_->art, side_px, frame);
}

void SightPainter::DrawAgentView(const Sight& sight, absl::Span<uint8_t> frame) {
  rasteriser_->DrawAgentView(sight.content_->scene, *sight.content_->art, nullptr,
                             kReleasedFrameFormat, frame);
}

}  // namespace procgen
