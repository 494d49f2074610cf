// Saving and restoring one environment. tests/envcore/pool/pool_states_test.cc tests for every game
// that restored environments continue like the saved ones.

#include <memory>
#include <string>

#include "envcore/environment/environment.h"
#include "envcore/state/snapshot_frame.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

using Json = nlohmann::ordered_json;

Environment Made(absl::string_view game, const EnvironmentOptions& options = {},
                 AutoresetMode autoreset_mode = AutoresetMode::kSameStep) {
  return {*FindGame(game), *ResolveOptions(game, options), 42, autoreset_mode};
}

void Step(Environment& environment, int32_t action) {
  environment.Step(action, 1, [] {});
}

std::string Saved(Environment& environment) {
  absl::StatusOr<std::string> snapshot = environment.SaveState();
  EXPECT_THAT(snapshot, IsOk());
  return snapshot.value_or("");
}

absl::StatusOr<std::unique_ptr<Environment>> Restored(
    absl::string_view snapshot, absl::string_view game = "maze",
    AutoresetMode autoreset_mode = AutoresetMode::kSameStep) {
  return Environment::Restore(*FindGame(game), snapshot, autoreset_mode);
}

// The content of a new environment's snapshot, and the snapshot with the given content.
Json TreeOf(absl::string_view game) {
  Environment environment = Made(game);
  return Json::from_cbor(Saved(environment).substr(kSnapshotHeaderBytes));
}

std::string Encoded(const Json& tree) {
  std::string body;
  Json::to_cbor(tree, body);
  return FrameSnapshot(body);
}

// A snapshot of a maze with one field changed.
std::string With(const std::string& field, const Json& value) {
  Json tree = TreeOf("maze");
  tree[Json::json_pointer(field)] = value;
  return Encoded(tree);
}

// A snapshot of coinrun with the agent, `count` copies of `entity` and, last, a crate.
std::string CoinRunWith(int count, Json entity) {
  Json tree = TreeOf("coinrun");
  Json& entities = tree["level"]["world"]["entities"];
  const Json agent = entities[0];
  entity.update({{"image_kind", 0}, {"x", 5.5}, {"y", 5.5}});
  entities = Json::array({agent});
  for (int i = 0; i < count; ++i) {
    entities.push_back(entity);
  }
  entities.push_back(
      {{"kind", 20}, {"x", 5.5}, {"y", 5.5}, {"rx", 0.5}, {"ry", 0.5}, {"image_kind", 20}});
  return Encoded(tree);
}

TEST(EnvironmentStateTest, ThePendingNextLevelIsRestored) {
  Environment environment = Made("maze");
  environment.SetNextLevel(77);
  const auto restored = Restored(Saved(environment));
  ASSERT_THAT(restored, IsOk());
  Step(**restored, kEndEpisodeAction);
  EXPECT_EQ((*restored)->result().level_seed, 77);
}

TEST(EnvironmentStateTest, AnEndedEpisodeFollowsTheAutoresetModeOfTheRestore) {
  for (const AutoresetMode saved : {AutoresetMode::kNextStep, AutoresetMode::kDisabled}) {
    Environment environment = Made("maze", {}, saved);
    Step(environment, kEndEpisodeAction);
    const std::string snapshot = Saved(environment);
    const auto disabled = Restored(snapshot, "maze", AutoresetMode::kDisabled);
    ASSERT_THAT(disabled, IsOk());
    EXPECT_TRUE((*disabled)->awaits_reset());
    for (const AutoresetMode autoreset_mode :
         {AutoresetMode::kSameStep, AutoresetMode::kNextStep}) {
      const auto restored = Restored(snapshot, "maze", autoreset_mode);
      ASSERT_THAT(restored, IsOk());
      EXPECT_FALSE((*restored)->awaits_reset());
      EXPECT_EQ(Saved(**restored), snapshot);
      Step(**restored, 7);
      EXPECT_TRUE((*restored)->result().first);
      EXPECT_EQ((*restored)->result().episode_length, 0);
    }
  }
}

TEST(EnvironmentStateTest, ARunningEpisodeFollowsTheAutoresetModeOfTheRestore) {
  Environment environment = Made("maze", {}, AutoresetMode::kSameStep);
  Step(environment, kEndEpisodeAction);
  const auto restored = Restored(Saved(environment), "maze", AutoresetMode::kDisabled);
  ASSERT_THAT(restored, IsOk());
  EXPECT_FALSE((*restored)->awaits_reset());  // the next episode had begun
  Step(**restored, 7);
  Step(**restored, kEndEpisodeAction);
  EXPECT_TRUE((*restored)->awaits_reset());
}

TEST(EnvironmentStateTest, ExplorationIsRestoredAsResolved) {
  EnvironmentOptions options;
  options.distribution_mode = DistributionMode::kExploration;
  Environment environment = Made("coinrun", options);
  const auto restored = Restored(Saved(environment), "coinrun");
  ASSERT_THAT(restored, IsOk());
  Step(**restored, kEndEpisodeAction);
  EXPECT_EQ((*restored)->result().level_seed, environment.result().level_seed);
}

TEST(EnvironmentStateTest, OptionsOutOfRangeAreNamed) {
  EXPECT_THAT(Restored(With("/options/distribution_mode", 2)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "options: distribution_mode is extreme (2), maze has easy, hard, memory, "
                       "exploration"));
  EXPECT_THAT(Restored(With("/options/num_levels", -1)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("options.num_levels is -1")));
}

TEST(EnvironmentStateTest, FieldsOutOfRangeAreNamed) {
  EXPECT_THAT(Restored(With("/level/world/entities/0/vx", 9.5)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "level.world.entities[0].vx is 9.5, must be in [-8, 8]"));
  EXPECT_THAT(Restored(With("/level/step_number", 501)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "level.step_number is 501, must be in [0, 500]"));
  EXPECT_THAT(Restored(With("/level/world/cells", Json::array({51, 100}))),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("level.world has cells that are not runs")));
  EXPECT_THAT(Restored(With("/level/random/seed", 1)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "level has a stream that was not seeded with level_seed"));
}

TEST(EnvironmentStateTest, EntitiesThatBlockLikeCellsAreRejected) {
  EXPECT_THAT(
      Restored(With(
          "/level/world/entities/1",
          {{"kind", 51}, {"x", 1.5}, {"y", 1.5}, {"rx", 0.5}, {"ry", 0.5}, {"image_kind", 51}})),
      StatusIs(absl::StatusCode::kInvalidArgument,
               "level has an entity of kind 51, which only cells can have"));
}

TEST(EnvironmentStateTest, WorldsThatMakeStepsSlowAreRejected) {
  const Json entity = {{"kind", 1},  {"x", 1.5},  {"y", 1.5},
                       {"rx", 0.25}, {"ry", 0.5}, {"image_kind", 1}};
  Json tree = TreeOf("bigfish");
  Json& entities = tree["level"]["world"]["entities"];
  while (entities.size() < 1024) {
    entities.push_back(entity);
  }
  EXPECT_THAT(Restored(Encoded(tree), "bigfish"), IsOk());
  for (size_t i = 1; i < 128; ++i) {
    entities[i]["smart"] = true;
  }
  EXPECT_THAT(Restored(Encoded(tree), "bigfish"), IsOk());
  entities[128]["smart"] = true;
  EXPECT_THAT(Restored(Encoded(tree), "bigfish"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("level.world has more than 128 smart entities")));
  entities.push_back(entity);
  EXPECT_THAT(Restored(Encoded(tree), "bigfish"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("entities has 1025 entries, must have from 1 to 1024")));
}

// Each walker would be pushed between the crates around it over and over again.
TEST(EnvironmentStateTest, CrowdedCratesAreRejected) {
  const Json crate = {{"kind", 20}, {"rx", 0.5}, {"ry", 0.5}};
  const Json walker = {{"kind", 5}, {"rx", 0.5}, {"ry", 0.5}, {"smart", true}};
  Json broad = walker;
  broad["rx"] = 0.75;
  Json fast = walker;
  fast["vy"] = 1.0;
  EXPECT_THAT(Restored(CoinRunWith(39, walker), "coinrun"), IsOk());
  EXPECT_THAT(Restored(CoinRunWith(1, crate), "coinrun"), IsOk());
  for (const std::string& snapshot : {CoinRunWith(40, walker), CoinRunWith(2, crate),
                                      CoinRunWith(1, broad), CoinRunWith(1, fast)}) {
    EXPECT_THAT(Restored(snapshot, "coinrun"),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         "level.own has more or other crates and walkers than levels can have"));
  }
}

}  // namespace
}  // namespace procgen
