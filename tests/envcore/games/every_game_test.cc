// Tests that run on every game, in each of its modes.

#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/games/game_catalog.h"
#include "envcore/random/random_stream.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

struct GameInMode {
  const GameSpec* spec;
  DistributionMode mode;
};

std::vector<GameInMode> AllGamesInAllModes() {
  std::vector<GameInMode> all;
  for (const GameSpec& spec : GameCatalog()) {
    for (const DistributionMode mode : spec.modes) {
      all.push_back({&spec, mode});
    }
  }
  return all;
}

// Plays levels with random actions that are held for some steps, like a learner's.
class RandomPlay {
 public:
  RandomPlay(const GameInMode& game, int32_t seed, GameOptions options = {}) : random_(seed) {
    options.distribution_mode = game.mode;
    game_ = game.spec->make(options);
    game_->StartLevel(seed);
  }

  void Step() {
    if (random_.Int(4) == 0) {
      action_ = random_.Int(kActionCount);
    }
    game_->Play(action_);
    if (game_->outcome().done) {
      game_->StartLevel(random_.Int(1000));
    }
  }

  Game& game() { return *game_; }

 private:
  RandomStream random_;
  std::unique_ptr<Game> game_;
  int32_t action_ = 7;
};

// The states after each of `step_count` steps.
std::vector<std::string> Play(RandomPlay play, int step_count) {
  std::vector<std::string> states;
  for (int i = 0; i < step_count; ++i) {
    play.Step();
    states.push_back(StateOf(play.game()));
  }
  return states;
}

class EveryGameTest : public testing::TestWithParam<GameInMode> {};

// The state after taking `action` at step `step_count` of a random play.
std::string StateAfter(const GameInMode& game, int step_count, int32_t action) {
  RandomPlay play(game, step_count);
  for (int i = 0; i < step_count; ++i) {
    play.Step();
  }
  play.game().Play(action);
  return StateOf(play.game());
}

// Compares with action 4, which does nothing.
TEST_P(EveryGameTest, SpecialActionsDoSomethingIfTheCatalogSaysSo) {
  constexpr int32_t kNothing = 4;
  std::set<int32_t> effective;
  for (int step_count = 0; step_count < 60; step_count += 4) {
    const std::string unchanged = StateAfter(GetParam(), step_count, kNothing);
    for (int32_t action = 9; action < kActionCount; ++action) {
      if (StateAfter(GetParam(), step_count, action) != unchanged) {
        effective.insert(action);
      }
    }
  }
  std::set<int32_t> listed;
  for (const SpecialAction& special : GetParam().spec->special_actions) {
    listed.insert(special.action);
  }
  EXPECT_EQ(effective, listed);
}

// A game can be played after its level has ended; the caller decides.
TEST_P(EveryGameTest, ALevelThatIsOverCanBePlayedOn) {
  RandomPlay play(GetParam(), 4);
  for (int i = 0; i < 1200; ++i) {
    play.game().Play((i / 7) % kActionCount);
  }
  EXPECT_EQ(play.game().step_number(), 1200);
}

TEST_P(EveryGameTest, FillingASceneChangesNothing) {
  const std::vector<std::string> unseen = Play(RandomPlay(GetParam(), 5), 300);
  RandomPlay seen(GetParam(), 5);
  Scene scene;
  for (size_t i = 0; i < unseen.size(); ++i) {
    seen.game().FillScene(&scene);
    seen.Step();
    seen.game().FillScene(&scene);
    seen.game().FillScene(&scene);
    ASSERT_EQ(StateOf(seen.game()), unseen[i]) << "step " << i;
  }
}

// Options that affect the appearance only.
TEST_P(EveryGameTest, AppearanceOptionsChangeNoRule) {
  const std::vector<std::string> plain = Play(RandomPlay(GetParam(), 6), 200);
  EXPECT_EQ(Play(RandomPlay(GetParam(), 6, {.use_backgrounds = false}), 200), plain);
  EXPECT_EQ(Play(RandomPlay(GetParam(), 6, {.use_monochrome_assets = true}), 200), plain);
  EXPECT_EQ(Play(RandomPlay(GetParam(), 6, {.center_agent = false}), 200), plain);
  EXPECT_EQ(Play(RandomPlay(GetParam(), 6, {.paint_vel_info = true}), 200), plain);
}

INSTANTIATE_TEST_SUITE_P(Catalog, EveryGameTest, testing::ValuesIn(AllGamesInAllModes()),
                         [](const auto& info) {
                           return absl::StrCat(info.param.spec->name, "_",
                                               DistributionModeName(info.param.mode));
                         });

}  // namespace
}  // namespace procgen
