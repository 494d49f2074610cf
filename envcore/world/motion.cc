#include "envcore/world/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "envcore/world/kinds.h"

namespace procgen {
namespace {

constexpr int kSubStepsMin = 4;
constexpr float kCornerShare = 0.98F;      // corner probes, as a fraction of the half-sizes
constexpr float kOverlapMargin = -0.001F;  // entities that only touch do not block each other
constexpr int kPushDepthMax = 5;           // chained pushes out of entities that overlap

// How the cells under the four corners of a box affect it.
struct CellAnswer {
  bool blocked = false;
  bool reflected = false;
};

CellAnswer AskCells(const World& world, Rules& rules, const Entity& entity, float x, float y,
                    Axis axis) {
  CellAnswer answer;
  std::optional<int> asked;  // usually all four corners are over cells of one kind
  for (const float side_x : {-1.0F, 1.0F}) {
    for (const float side_y : {-1.0F, 1.0F}) {
      const int kind = world.CellAtPoint(x + (entity.rx * kCornerShare) * side_x,
                                         y + (entity.ry * kCornerShare) * side_y);
      if (asked == kind) {
        continue;
      }
      asked = kind;
      answer.blocked = answer.blocked || rules.Blocks(entity, kind, axis);
      answer.reflected = answer.reflected || rules.Reflects(entity, kind);
    }
  }
  return answer;
}

// The center of a box that is reflected at the cell edge that it has crossed.
float ReflectedCenter(float center, float radius, bool toward_lower) {
  const float reach = toward_lower ? center - radius : center + radius;
  const float edge = toward_lower ? std::ceil(reach) : std::floor(reach);
  return center + 2 * (edge - reach);
}

// The center of a box that is flush with the cell edge that it has crossed.
float SnappedCenter(float center, float radius, bool toward_upper) {
  return toward_upper ? std::floor(center + radius) - radius : std::ceil(center - radius) + radius;
}

// The move along an axis that makes a box flush with another. In f64, as the rules require.
float PushOut(float center, float radius, float other_center, float other_radius) {
  const float reach = other_radius + radius;
  const double side = center > other_center ? 1.0 : (center < other_center ? -1.0 : 0.0);
  return static_cast<float>(static_cast<double>(other_center) + side * static_cast<double>(reach) -
                            static_cast<double>(center));
}

// The move of a box that is reflected by another.
float ThrowBack(float center, float radius, float other_center, float other_radius,
                bool toward_upper) {
  const float distance = other_center - center;
  const float reach = other_radius + radius;
  return toward_upper ? -2 * (reach - distance) : 2 * (reach + distance);
}

// The entities near one entity, without effects. A move is divided into many sub-steps; only these
// entities are tested in each.
class Neighbours {
 public:
  Neighbours(const World& world, const Entity& entity) : world_(world), entity_(entity) {
    reach_x_ = std::fabs(entity.vx) + kSpare;
    reach_y_ = std::fabs(entity.vy) + kSpare;
    Find();
  }

  // Returns the last entity with an index below `end` that may overlap the entity at its current
  // position, and sets `end` to its index. Null: there is none.
  const Entity* LastBefore(size_t* end) {
    if (std::fabs(entity_.x - center_x_) > reach_x_ ||
        std::fabs(entity_.y - center_y_) > reach_y_) {
      Find();
    }
    if (are_too_many_) {
      return *end == 0 ? nullptr : &world_.entities[--*end];
    }
    for (size_t i = 0; i < count_; ++i) {
      if (numbers_[i] < *end) {
        *end = numbers_[i];
        return &world_.entities[*end];
      }
    }
    return nullptr;
  }

 private:
  static constexpr size_t kCountMax = 16;
  static constexpr float kSpare = 0.25F;  // more than most pushes, plus rounding errors

  void Find() {
    center_x_ = entity_.x;
    center_y_ = entity_.y;
    count_ = 0;
    are_too_many_ = false;
    for (size_t i = world_.entities.size(); i-- > 0;) {
      const Entity& other = world_.entities[i];
      if (std::fabs(other.x - center_x_) > other.rx + entity_.rx + reach_x_ + kSpare ||
          std::fabs(other.y - center_y_) > other.ry + entity_.ry + reach_y_ + kSpare ||
          IsEffect(other.kind) || &other == &entity_) {
        continue;
      }
      if (count_ == kCountMax) {
        are_too_many_ = true;
        return;
      }
      numbers_[count_++] = i;
    }
  }

  const World& world_;
  const Entity& entity_;
  float reach_x_ = 0;  // distance from the center within which the list is valid
  float reach_y_ = 0;
  float center_x_ = 0;
  float center_y_ = 0;
  bool are_too_many_ = false;  // the list is full: test all entities
  size_t count_ = 0;
  std::array<size_t, kCountMax> numbers_;  // indices in the world, highest first
};

class Mover {
 public:
  Mover(World& world, Rules& rules, Entity& entity)
      : world_(world), rules_(rules), entity_(entity), neighbours_(world, entity) {}

  // Moves by (dx, dy), one of which is 0. Returns whether the move was blocked.
  bool MoveElementary(  // NOLINT(misc-no-recursion): at most kPushDepthMax deep
      float dx, float dy, int depth) {
    if (entity_.marked) {
      return false;
    }
    const Axis axis = dx != 0 ? Axis::kHorizontal : Axis::kVertical;
    bool blocked = MoveThroughCells(dx, dy, axis);
    size_t number = world_.entities.size();
    while (const Entity* near = neighbours_.LastBefore(&number)) {
      const Entity& other = *near;
      if (&other == &entity_ || other.marked || !Overlap(entity_, other, kOverlapMargin)) {
        continue;
      }
      if (rules_.EntityBlocks(entity_, other, axis)) {
        blocked = true;
        PushOutOf(other, axis, depth);
      } else if (rules_.Reflects(entity_, other.kind)) {
        ThrowBackFrom(other, axis, axis == Axis::kHorizontal ? dx > 0 : dy > 0);
      }
    }
    return blocked;
  }

 private:
  bool MoveThroughCells(float dx, float dy, Axis axis) {
    float x = entity_.x + dx;
    float y = entity_.y + dy;
    const CellAnswer answer = AskCells(world_, rules_, entity_, x, y, axis);
    if (answer.reflected) {
      if (axis == Axis::kHorizontal) {
        x = ReflectedCenter(x, entity_.rx, dx < 0);
        entity_.vx = -entity_.vx;
      } else {
        y = ReflectedCenter(y, entity_.ry, dy < 0);
        entity_.vy = -entity_.vy;
      }
    } else if (answer.blocked) {
      if (axis == Axis::kHorizontal) {
        x = world_.whole_cell_motion ? entity_.x : SnappedCenter(x, entity_.rx, dx > 0);
      } else {
        y = world_.whole_cell_motion ? entity_.y : SnappedCenter(y, entity_.ry, dy > 0);
      }
    }
    entity_.x = x;
    entity_.y = y;
    if (answer.blocked) {
      rules_.OnStoppedByCell(entity_, axis);
    }
    return answer.blocked;
  }

  void PushOutOf(  // NOLINT(misc-no-recursion): at most kPushDepthMax deep
      const Entity& other, Axis axis, int depth) {
    if (axis == Axis::kHorizontal) {
      const float way = PushOut(entity_.x, entity_.rx, other.x, other.rx);
      if (depth < kPushDepthMax) {
        MoveElementary(way, 0, depth + 1);
      }
      entity_.vx = 0;
    } else {
      const float way = PushOut(entity_.y, entity_.ry, other.y, other.ry);
      if (depth < kPushDepthMax) {
        MoveElementary(0, way, depth + 1);
      }
      entity_.vy = 0;
    }
  }

  void ThrowBackFrom(const Entity& other, Axis axis, bool toward_upper) {
    if (axis == Axis::kHorizontal) {
      entity_.x += ThrowBack(entity_.x, entity_.rx, other.x, other.rx, toward_upper);
      entity_.vx = -entity_.vx;
    } else {
      entity_.y += ThrowBack(entity_.y, entity_.ry, other.y, other.ry, toward_upper);
      entity_.vy = -entity_.vy;
    }
  }

  World& world_;
  Rules& rules_;
  Entity& entity_;
  Neighbours neighbours_;
};

bool MovesHorizontallyFirst(const World& world, const Entity& entity) {
  if (entity.kind == kAgentKind) {
    if (world.controls.vertical != 0) {
      return false;
    }
    if (world.controls.horizontal != 0) {
      return true;
    }
  }
  const float lead = std::fabs(entity.vx) - std::fabs(entity.vy);
  return lead == 0 ? world.shared_random % 2 == 0 : lead > 0;
}

}  // namespace

void MoveSmart(World& world, Rules& rules, Entity& entity) {
  if (entity.marked) {
    return;
  }
  int sub_steps = 1;
  if (!world.whole_cell_motion) {
    const float speed_squared = entity.vx * entity.vx + entity.vy * entity.vy;
    sub_steps =
        std::max(kSubStepsMin, static_cast<int>(4 * std::sqrt(static_cast<double>(speed_squared))));
  }
  const auto share = static_cast<float>(1.0 / sub_steps);
  const bool horizontal_first = MovesHorizontallyFirst(world, entity);

  Mover mover(world, rules, entity);
  int free_x = 0;
  int free_y = 0;
  for (int i = 0; i < sub_steps; ++i) {
    bool blocked_x = false;
    bool blocked_y = false;
    const std::array<float, 4> before = {entity.x, entity.y, entity.vx, entity.vy};
    if (horizontal_first) {
      blocked_x = mover.MoveElementary(entity.vx * share, 0, 0);
      blocked_y = mover.MoveElementary(0, entity.vy * share, 0);
    } else {
      blocked_y = mover.MoveElementary(0, entity.vy * share, 0);
      blocked_x = mover.MoveElementary(entity.vx * share, 0, 0);
    }
    free_x += blocked_x ? 0 : 1;
    free_y += blocked_y ? 0 : 1;
    if (blocked_x && blocked_y) {
      break;
    }
    if (!blocked_x && !blocked_y &&
        before == std::array<float, 4>{entity.x, entity.y, entity.vx, entity.vy}) {
      const int rest = sub_steps - i - 1;  // equal to this one: unblocked, without moving
      free_x += rest;
      free_y += rest;
      break;
    }
  }
  entity.vx *= static_cast<float>(free_x) / static_cast<float>(sub_steps);
  entity.vy *= static_cast<float>(free_y) / static_cast<float>(sub_steps);
}

}  // namespace procgen
