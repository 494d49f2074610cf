#include "envcore/world/support.h"

namespace procgen {
namespace {

constexpr double kFeetMargin = 0.01;  // cells, downward and inward from the corners of the box

}  // namespace

bool StandsOn(const World& world, const Entity& entity, bool (*carries)(int kind)) {
  const auto feet_y = static_cast<float>(entity.y - (entity.ry + kFeetMargin));
  const auto left_x = static_cast<float>(entity.x - (entity.rx - kFeetMargin));
  const auto right_x = static_cast<float>(entity.x + (entity.rx - kFeetMargin));
  return carries(world.CellAtPoint(left_x, feet_y)) || carries(world.CellAtPoint(right_x, feet_y));
}

}  // namespace procgen
