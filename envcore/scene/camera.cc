#include "envcore/scene/camera.h"

namespace procgen {
namespace {

constexpr float kAgentViewSizePx = 64;
constexpr float kCellOverdraw = 0.02F;

}  // namespace

Viewport::Viewport(const Camera& camera, int size_px) : size_px_(size_px) {
  const float agent_view_scale = kAgentViewSizePx / camera.cells;
  pixels_per_cell_ = static_cast<float>(static_cast<double>(agent_view_scale) *
                                        (static_cast<double>(size_px) / kAgentViewSizePx));
  cells_ = static_cast<float>(64.0 / static_cast<double>(agent_view_scale));
  offset_x_ = pixels_per_cell_ * (camera.center_x - cells_ / 2);
  offset_y_ = pixels_per_cell_ * (camera.center_y - cells_ / 2);
}

ScreenRect Viewport::InWorld(float x, float y, float width, float height, float overdraw) const {
  const float left = (x - overdraw) * pixels_per_cell_ - offset_x_;
  const float top = ((cells_ - y) - overdraw) * pixels_per_cell_ + offset_y_;
  const float screen_width = (width + 2 * overdraw) * pixels_per_cell_;
  const float screen_height = (height + 2 * overdraw) * pixels_per_cell_;
  return {left, top, screen_width, screen_height};
}

ScreenRect Viewport::OfBox(float x, float y, float rx, float ry) const {
  return InWorld(x - rx, y + ry, 2 * rx, 2 * ry, 0);
}

ScreenRect Viewport::OfCell(int x, int y) const {
  return InWorld(static_cast<float>(x), static_cast<float>(y + 1), 1, 1, kCellOverdraw);
}

ScreenRect Viewport::OfShares(float x, float y, float rx, float ry) const {
  const float left = (cells_ * (x - rx)) * pixels_per_cell_;
  const float top = (cells_ * (y + ry)) * pixels_per_cell_;
  const float width = ((2 * cells_) * rx) * pixels_per_cell_;
  const float height = ((2 * cells_) * ry) * pixels_per_cell_;
  return {left, top, width, height};
}

}  // namespace procgen
