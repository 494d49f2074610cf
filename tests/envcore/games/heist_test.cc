#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kLockKind = 1;
constexpr int kKeyKind = 2;

constexpr int32_t kRight = 7;

// An open floor with the thief at (5, 5).
std::unique_ptr<Game> StagedFloor() {
  auto game = StartedGame("heist", 0);
  StageAgentAlone(*game, 5, 5);
  return game;
}

void AddAt(Game& game, int kind, int color, float x) {
  Entity& entity =
      Stage(game).entities.emplace_back(Entity::Make(kind, x, 5, 0, 0, 0.375F, 0.375F));
  entity.theme = color;
}

TEST(HeistTest, ALockOpensInTheStepOfAKeyThatIsLaterInTheList) {
  for (const bool key_is_later : {true, false}) {
    const auto game = StagedFloor();
    AddAt(*game, key_is_later ? kLockKind : kKeyKind, 2, 5.5F);
    AddAt(*game, key_is_later ? kKeyKind : kLockKind, 2, 5.5F);
    game->Play(kNoAction);
    EXPECT_EQ(game->world().entities.size(), key_is_later ? 1U : 2U);
    game->Play(kRight);
    EXPECT_EQ(game->world().entities.size(), 1U);
  }
}

}  // namespace
}  // namespace procgen
