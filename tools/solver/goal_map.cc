#include "tools/solver/goal_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <queue>
#include <utility>

namespace procgen {
namespace {

constexpr int32_t kNoWay = -1;

// The nearest cell in the grid.
int32_t CellAt(const Grid& grid, int column, int row) {
  return grid.IndexOf(std::clamp(column, 0, grid.width() - 1),
                      std::clamp(row, 0, grid.height() - 1));
}

int32_t CellOf(const Grid& grid, float x, float y) {
  return CellAt(grid, static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
}

// Adds the cells whose centers are in the entity's box; if there is none, the cell of its own
// center.
void AddCells(const Grid& grid, const Entity& entity, std::vector<int32_t>* cells) {
  const size_t count_before = cells->size();
  const int first_column = static_cast<int>(std::ceil(entity.x - entity.rx - 0.5F));
  const int last_column = static_cast<int>(std::floor(entity.x + entity.rx - 0.5F));
  const int first_row = static_cast<int>(std::ceil(entity.y - entity.ry - 0.5F));
  const int last_row = static_cast<int>(std::floor(entity.y + entity.ry - 0.5F));
  for (int column = first_column; column <= last_column; ++column) {
    for (int row = first_row; row <= last_row; ++row) {
      cells->push_back(CellAt(grid, column, row));
    }
  }
  if (cells->size() == count_before) {
    cells->push_back(CellOf(grid, entity.x, entity.y));
  }
}

}  // namespace

GoalDistance GoalMap::From(const World& world) {
  const Targets targets = TargetsIn(world);
  auto known = maps_.find(targets);
  if (known == maps_.end()) {
    Maps maps = {.to_goals = MakeMap(world, targets.goals, targets.closed_locks),
                 .to_keys = MakeMap(world, targets.keys, targets.closed_locks)};
    known = maps_.emplace(targets, std::move(maps)).first;
  }
  const auto cell = static_cast<size_t>(CellOf(world.grid, world.agent().x, world.agent().y));
  int32_t cells = known->second.to_goals[cell];
  if (cells == kNoWay) {
    cells = known->second.to_keys[cell];
  }
  return {.targets_left = targets.count,
          .cells = cells == kNoWay ? world.grid.size() : cells,
          .has_way = cells != kNoWay};
}

GoalMap::Targets GoalMap::TargetsIn(const World& world) const {
  Targets targets;
  for (int32_t cell = 0; cell < world.grid.size(); ++cell) {
    if (world.grid.At(cell) == heuristic_.goal_kind) {
      targets.goals.push_back(cell);
      ++targets.count;
    }
  }
  for (const Entity& entity : world.entities) {
    if (entity.kind == heuristic_.goal_kind) {
      AddCells(world.grid, entity, &targets.goals);
      ++targets.count;
    } else if (entity.kind == heuristic_.key_kind) {
      AddCells(world.grid, entity, &targets.keys);
      ++targets.count;
    } else if (entity.kind == heuristic_.lock_kind && IsShut(world, entity.theme)) {
      AddCells(world.grid, entity, &targets.closed_locks);
    }
  }
  return targets;
}

bool GoalMap::IsShut(const World& world, int theme) const {
  return std::any_of(world.entities.begin(), world.entities.end(), [&](const Entity& entity) {
    return entity.kind == heuristic_.key_kind && entity.theme == theme;
  });
}

bool GoalMap::IsClosed(int kind) const {
  return std::find(heuristic_.closed_kinds.begin(), heuristic_.closed_kinds.end(), kind) !=
         heuristic_.closed_kinds.end();
}

std::vector<int32_t> GoalMap::MakeMap(const World& world, const std::vector<int32_t>& targets,
                                      const std::vector<int32_t>& closed_locks) const {
  const Grid& grid = world.grid;
  std::vector<int32_t> map(static_cast<size_t>(grid.size()), kNoWay);
  std::queue<int32_t> reached;
  const auto reach = [&](int32_t cell, int32_t cells_to_go) {
    if (map[static_cast<size_t>(cell)] == kNoWay) {
      map[static_cast<size_t>(cell)] = cells_to_go;
      reached.push(cell);
    }
  };
  for (const int32_t target : targets) {
    reach(target, 0);
  }
  constexpr std::array<std::array<int, 2>, 4> kSteps = {{{-1, 0}, {0, -1}, {1, 0}, {0, 1}}};
  for (; !reached.empty(); reached.pop()) {
    const int32_t cell = reached.front();
    for (const auto& [dx, dy] : kSteps) {
      const int x = cell % grid.width() + dx;
      const int y = cell / grid.width() + dy;
      if (!grid.Contains(x, y) || IsClosed(grid.At(x, y))) {
        continue;
      }
      const int32_t neighbor = grid.IndexOf(x, y);
      if (std::find(closed_locks.begin(), closed_locks.end(), neighbor) == closed_locks.end()) {
        reach(neighbor, map[static_cast<size_t>(cell)] + 1);
      }
    }
  }
  return map;
}

}  // namespace procgen
