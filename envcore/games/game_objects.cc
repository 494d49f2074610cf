#include "envcore/games/game_objects.h"

#include <algorithm>

namespace procgen {
namespace {

// Writes objects to rows while there are some, and counts all.
class RowWriter {
 public:
  explicit RowWriter(absl::Span<ObjectRow> rows) : rows_(rows) {}

  void Add(const Entity& entity) {
    AddRow({.kind = static_cast<float>(entity.kind),
            .theme = static_cast<float>(entity.theme),
            .x = entity.x,
            .y = entity.y,
            .vx = entity.vx,
            .vy = entity.vy,
            .rx = entity.rx,
            .ry = entity.ry,
            .rotation = entity.rotation,
            .health = entity.health});
  }
  void AddCell(int kind, int x, int y) {
    AddRow({.kind = static_cast<float>(kind),
            .x = static_cast<float>(x) + 0.5F,
            .y = static_cast<float>(y) + 0.5F,
            .rx = 0.5F,
            .ry = 0.5F,
            .health = 1});
  }
  int32_t count() const { return count_; }

 private:
  void AddRow(const ObjectRow& row) {
    if (static_cast<size_t>(count_) < rows_.size()) {
      rows_[static_cast<size_t>(count_)] = row;
    }
    ++count_;
  }

  absl::Span<ObjectRow> rows_;
  int32_t count_ = 0;
};

void AddCells(const Grid& grid, int kind, RowWriter* writer) {
  for (int y = 0; y < grid.height(); ++y) {
    const absl::Span<const int16_t> row = grid.Row(y);
    for (const auto* cell = row.begin(); (cell = std::find(cell, row.end(), kind)) != row.end();
         ++cell) {
      writer->AddCell(kind, static_cast<int>(cell - row.begin()), y);
    }
  }
}

}  // namespace

int32_t ReadObjects(const World& world, absl::Span<const KindName> kinds,
                    absl::Span<ObjectRow> rows) {
  const auto is_goal = [kinds](int kind) {
    return std::any_of(kinds.begin(), kinds.end(),
                       [kind](const KindName& each) { return each.is_goal && each.kind == kind; });
  };
  RowWriter writer(rows);
  writer.Add(world.agent());
  const absl::Span<const Entity> others = absl::MakeConstSpan(world.entities).subspan(1);
  for (const bool goals : {true, false}) {
    for (const Entity& entity : others) {
      if (is_goal(entity.kind) == goals && !entity.screen_coordinates) {
        writer.Add(entity);
      }
    }
    for (size_t i = 0; goals && i < kinds.size(); ++i) {
      if (kinds[i].is_goal) {
        AddCells(world.grid, kinds[i].kind, &writer);
      }
    }
  }
  const size_t used = std::min(rows.size(), static_cast<size_t>(writer.count()));
  std::fill(rows.begin() + static_cast<std::ptrdiff_t>(used), rows.end(), ObjectRow());
  return writer.count();
}

}  // namespace procgen
