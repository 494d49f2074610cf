#include "server/web/play/agent_path.h"

#include <algorithm>
#include <memory>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "envcore/environment/environment.h"
#include "envcore/games/game_catalog.h"

namespace procgen::web {
namespace {

bool BeginsLevel(const Trace& trace, int32_t row) {
  const auto index = static_cast<size_t>(row);
  return row == 0 || trace.first[index] != 0 || trace.prev_level_complete[index] != 0;
}

// The whole level is shown in the middle of a square.
void AddPosition(const World& world, AgentPath* path) {
  const auto width = static_cast<float>(world.grid.width());
  const auto height = static_cast<float>(world.grid.height());
  const float cells = std::max(width, height);
  path->x.push_back(0.5F + (world.agent().x - width / 2) / cells);
  path->y.push_back(0.5F - (world.agent().y - height / 2) / cells);
}

}  // namespace

int32_t FirstRowOfLevel(const Trace& trace, int32_t row) {
  while (!BeginsLevel(trace, row)) {
    --row;
  }
  return row;
}

absl::StatusOr<AgentPath> FollowAgent(const std::string& game, const Trace& trace,
                                      const std::string& snapshot, int32_t snapshot_row,
                                      int32_t first_row) {
  const GameSpec* const spec = FindGame(game);
  if (spec == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("there is no game '", game, "'"));
  }
  const auto environment = Environment::Restore(*spec, snapshot, AutoresetMode::kSameStep);
  if (!environment.ok()) {
    return environment.status();
  }
  const auto step = [&](int32_t row, auto before_new_level) {
    (*environment)->Step(trace.actions[static_cast<size_t>(row)], 1, before_new_level);
  };
  for (int32_t row = snapshot_row; row < first_row; ++row) {
    step(row, [] {});
  }
  const World& world = (*environment)->game().world();
  AgentPath path;
  path.first_row = first_row;
  AddPosition(world, &path);
  for (int32_t row = first_row; row < trace.step_count; ++row) {
    step(row, [&] { AddPosition(world, &path); });
    const StepResult& result = (*environment)->result();
    if (result.first || result.prev_level_complete) {
      break;
    }
    AddPosition(world, &path);
  }
  return path;
}

}  // namespace procgen::web
