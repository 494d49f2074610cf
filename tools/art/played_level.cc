#include "tools/art/played_level.h"

#include <iterator>
#include <vector>

#include "envcore/environment/environment_options.h"
#include "envcore/random/random_stream.h"

namespace procgen {
namespace {

constexpr int32_t kStepsMax = 100;
constexpr int32_t kActionSteps = 5;  // steps that an action is held
// RIGHT (7) and RIGHT+UP (8) are more frequent, because platform games progress to the right.
constexpr int32_t kActions[] = {0, 1, 2, 3, 4, 5, 6, 7, 7, 8, 8, 9, 10, 11, 12, 13, 14};

}  // namespace

std::unique_ptr<Game> PlayedLevel(const GameSpec& spec, DistributionMode mode, int32_t level_seed) {
  EnvironmentOptions options;
  options.distribution_mode = mode;
  const EnvironmentOptions resolved = ResolveOptions(spec.name, options).value();
  RandomStream random(level_seed);
  std::vector<int32_t> actions;
  actions.reserve(kStepsMax);
  for (int32_t step = 0; step < kStepsMax; ++step) {
    actions.push_back(step % kActionSteps == 0
                          ? kActions[random.Int(static_cast<int32_t>(std::size(kActions)))]
                          : actions.back());
  }
  std::unique_ptr<Game> game = spec.make(resolved);
  game->StartLevel(level_seed);
  for (size_t step = 0; step < actions.size(); ++step) {
    game->Play(actions[step]);
    if (game->outcome().done) {
      // Starts again without the step that ended the level.
      actions.resize(step);
      game = spec.make(resolved);
      game->StartLevel(level_seed);
      for (const int32_t action : actions) {
        game->Play(action);
      }
    }
  }
  return game;
}

}  // namespace procgen
