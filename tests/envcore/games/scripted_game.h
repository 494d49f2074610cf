#ifndef TESTS_ENVCORE_GAMES_SCRIPTED_GAME_H_
#define TESTS_ENVCORE_GAMES_SCRIPTED_GAME_H_

#include <cstdint>
#include <memory>

#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"

namespace procgen {

// The actions of a scripted game, besides moves.
inline constexpr int32_t kRewardAction = 9;         // pays 1
inline constexpr int32_t kEndAction = 10;           // pays 2 and ends the level
inline constexpr int32_t kCompleteAction = 11;      // pays 4, completes and ends the level
inline constexpr int32_t kCompleteOnlyAction = 12;  // completes the level without ending it

inline constexpr int kScriptedWorldSide = 8;
inline constexpr int kThemedKind = 3;  // has three themes; the second is twice as wide as high
inline constexpr ArtSlot kScriptedSlots[] = {{kAgentKind, 0, "agent", "agent.png", 10, 10},
                                             {kThemedKind, 0, "thing", "thing_0.png", 10, 10},
                                             {kThemedKind, 1, "thing", "thing_1.png", 20, 10},
                                             {kThemedKind, 2, "thing", "thing_2.png", 10, 30}};
inline constexpr GameArtSpec kScriptedArt = {.slots = kScriptedSlots,
                                             .background_group = BackgroundGroup::kWater};

// A game whose actions determine the outcome, for tests of the code around games.
class ScriptedGame final : public Game {
 public:
  explicit ScriptedGame(const GameOptions& options) : Game(kScriptedArt, options) {}

  using Game::AspectRatio;
  using Game::DrawTheme;
  using Game::last_move_;
  using Game::special_action_;
  using Game::world_;

 private:
  void MakeLevel() override { StandardReset(kScriptedWorldSide, kScriptedWorldSide); }

  void PlayStep() override {
    StandardStep();
    const int32_t action = special_action_ == 0 ? kNoAction : special_action_ + 8;
    outcome_.reward = action == kRewardAction     ? 1.0F
                      : action == kEndAction      ? 2.0F
                      : action == kCompleteAction ? 4.0F
                                                  : 0.0F;
    outcome_.done = outcome_.done || action == kEndAction || action == kCompleteAction;
    outcome_.level_complete = action == kCompleteAction || action == kCompleteOnlyAction;
  }
};

inline std::unique_ptr<Game> MakeScriptedGame(const GameOptions& options) {
  return std::make_unique<ScriptedGame>(options);
}

// A catalog entry of the scripted game.
inline GameSpec ScriptedSpec(int32_t step_limit) {
  GameSpec spec = {};
  spec.name = "scripted";
  spec.step_limit = step_limit;
  spec.make = MakeScriptedGame;
  return spec;
}

}  // namespace procgen

#endif  // TESTS_ENVCORE_GAMES_SCRIPTED_GAME_H_
