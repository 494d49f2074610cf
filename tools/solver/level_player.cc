#include "tools/solver/level_player.h"

#include <cstdlib>

#include "envcore/state/state_archive.h"

namespace procgen {

LevelPlayer::LevelPlayer(const GameSpec& spec, DistributionMode mode, int32_t level_seed)
    : step_limit_(spec.StepLimit(mode)) {
  GameOptions options;
  options.distribution_mode = mode;
  game_ = spec.make(options);
  game_->StartLevel(level_seed);
}

std::string LevelPlayer::Save() {
  StateArchive archive;
  game_->VisitState(archive, step_limit_);
  return archive.Finish().value();
}

void LevelPlayer::Restore(absl::string_view state) {
  StateArchive archive = StateArchive::Open(state).value();
  game_->VisitState(archive, step_limit_);
  if (!archive.Close().ok()) {
    std::abort();
  }
}

}  // namespace procgen
