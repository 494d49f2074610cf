// Snapshots as JSON: the way there and back in every game and mode, edits, and what is rejected.

#include "envcore/environment/readable_state.h"

#include <functional>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "envcore/environment/environment.h"
#include "envcore/random/random_stream.h"
#include "envcore/state/snapshot_tree.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

using Json = SnapshotTree;

constexpr int kStepCount = 120;
constexpr int kStepsBetweenStates = 30;

Environment NewEnvironment(absl::string_view game,
                           DistributionMode mode = DistributionMode::kEasy) {
  EnvironmentOptions options;
  options.distribution_mode = mode;
  return {*FindGame(game), *ResolveOptions(game, options), 7, AutoresetMode::kSameStep};
}

void TakeStep(Environment& environment, int32_t action) {
  environment.Step(action, 1, [] {});
}

Json JsonOf(const std::string& snapshot) {
  const StatusOr<std::string> text = SnapshotToJson(snapshot);
  EXPECT_THAT(text, IsOk());
  return Json::parse(*text);
}

StatusOr<std::string> FromJson(const Json& json) { return SnapshotFromJson(json.dump()); }

std::string Snapshot(absl::string_view game) { return NewEnvironment(game).SaveState().value(); }

// The snapshot of a game after a change of its JSON.
StatusOr<std::string> Edited(absl::string_view game, const std::function<void(Json&)>& change) {
  Json json = JsonOf(Snapshot(game));
  change(json);
  return FromJson(json);
}

TEST(ReadableStateTest, TheJsonOfEveryGameAndModeGivesTheSameSnapshot) {
  RandomStream random(3);
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : game.modes) {
      Environment environment = NewEnvironment(game.name, mode);
      for (int step = 0; step < kStepCount; ++step) {
        SCOPED_TRACE(absl::StrCat(game.name, " ", DistributionModeName(mode), " step ", step));
        TakeStep(environment, random.Int(kActionCount));
        if (step % kStepsBetweenStates != 0) {
          continue;
        }
        const std::string snapshot = environment.SaveState().value();
        const Json json = JsonOf(snapshot);
        EXPECT_EQ(json["edited"], false);
        EXPECT_THAT(FromJson(json), IsOkAndHolds(snapshot));
      }
    }
  }
}

TEST(ReadableStateTest, EveryKindOfEveryGameHasAName) {
  RandomStream random(5);
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : game.modes) {
      Environment environment = NewEnvironment(game.name, mode);
      for (int step = 0; step < 6 * kStepCount; ++step) {
        TakeStep(environment, random.Int(kActionCount));
        const World& world = environment.game().world();
        for (const Entity& entity : world.entities) {
          ASSERT_NE(game.NameOfKind(entity.kind), "") << game.name << " " << entity.kind;
        }
        for (int cell = 0; step % kStepsBetweenStates == 0 && cell < world.grid.size(); ++cell) {
          ASSERT_NE(game.NameOfKind(world.grid.At(cell)), "")
              << game.name << " " << world.grid.At(cell);
        }
      }
    }
  }
}

// Otherwise a small change elsewhere in a state that was played would be rejected.
TEST(ReadableStateTest, AgentsAreNeverInBlocks) {
  RandomStream random(9);
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : game.modes) {
      Environment environment = NewEnvironment(game.name, mode);
      for (int step = 0; step < 3 * kStepCount; ++step) {
        TakeStep(environment, random.Int(kActionCount));
        ASSERT_THAT(environment.MarkEdited(1), IsOk()) << game.name << " step " << step;
      }
    }
  }
}

TEST(ReadableStateTest, FieldsHaveNamesAndFewDigits) {
  const std::string text = SnapshotToJson(Snapshot("coinrun")).value();
  EXPECT_THAT(text,
              HasSubstr("\"agent\": {\"x\":1.5,\"y\":1.5787001,\"vx\":0.0,\"vy\":0.0,\"rx\":0.5,"
                        "\"ry\":0.5787,"));
  const Json json = Json::parse(text);
  EXPECT_EQ(json["grid"].size(), 64);
  EXPECT_EQ(json["grid"][0][1], "ground_top");
  EXPECT_EQ(json["grid"][1][1], "empty");
  EXPECT_FALSE(json["level"]["world"].contains("cells"));
}

TEST(ReadableStateTest, AnEditedStateIsPlayedAndMarkedUntilTheNextEpisode) {
  Environment exact = NewEnvironment("maze");
  const auto snapshot = Edited("maze", [](Json& json) {
    const auto x = json["agent"]["x"].get<int>();
    const auto y = json["agent"]["y"].get<int>();
    for (Json& row : json["grid"]) {
      for (Json& cell : row) {
        cell = "empty";
      }
    }
    json["grid"][y][x + 1] = "cheese";
  });
  ASSERT_THAT(snapshot, IsOk());
  const auto environment =
      Environment::Restore(*FindGame("maze"), *snapshot, AutoresetMode::kNextStep);
  ASSERT_THAT(environment, IsOk());
  EXPECT_TRUE((*environment)->edited());
  TakeStep(**environment, 7);  // RIGHT
  TakeStep(exact, 7);
  EXPECT_EQ((*environment)->result().reward, 10);
  EXPECT_TRUE((*environment)->result().terminated);
  EXPECT_EQ(JsonOf((*environment)->SaveState().value())["edited"], true);
  TakeStep(**environment, 4);
  EXPECT_FALSE((*environment)->edited());
}

TEST(ReadableStateTest, AnEditChangesTheFingerprintAndIsKept) {
  const std::string snapshot = Snapshot("bigfish");
  const auto changed = Edited("bigfish", [](Json& json) { json["agent"]["vx"] = 0.25; });
  ASSERT_THAT(changed, IsOk());
  Json json = JsonOf(*changed);
  EXPECT_EQ(json["edited"], true);
  EXPECT_NE(json["fingerprint"], JsonOf(snapshot)["fingerprint"]);
  EXPECT_THAT(FromJson(json), IsOkAndHolds(*changed));
  json["edited"] = false;
  EXPECT_EQ(JsonOf(FromJson(json).value())["edited"], true);
}

TEST(ReadableStateTest, EntitiesCanBeAddedByTheirKind) {
  const auto snapshot = Edited("heist", [](Json& json) {
    json["entities"].push_back(
        {{"kind", "key"}, {"x", 4.5}, {"y", 4.5}, {"rx", 0.25}, {"ry", 0.25}});
  });
  ASSERT_THAT(snapshot, IsOk());
  const Json entity = JsonOf(*snapshot)["entities"].back();
  EXPECT_EQ(entity["kind"], "key");
  EXPECT_FALSE(entity.contains("image_kind"));
}

struct Rejected {
  std::string message;
  std::function<void(Json&)> change;
};

TEST(ReadableStateTest, WhatNoLevelCanHaveIsRejectedByItsName) {
  const Rejected all[] = {
      {"agent.vx is 9, must be in [-8, 8]", [](Json& json) { json["agent"]["vx"] = 9; }},
      {"agent.x is missing", [](Json& json) { json["agent"].erase("x"); }},
      {"agent has the unknown field speed; its fields are kind, x, y, vx",
       [](Json& json) { json["agent"]["speed"] = 1.0; }},
      {"agent is at (0.5, 0.5), must be in a cell that does not block it",
       [](Json& json) {
         json["agent"]["x"] = 0.5;
         json["agent"]["y"] = 0.5;
       }},
      {"agent is missing, must be a group of fields", [](Json& json) { json.erase("agent"); }},
      {"agent.x is not a float", [](Json& json) { json["agent"]["x"] = "left"; }},
      {"entities[0].kind is \"dragon\", coinrun has agent, wall, explosion, trail, empty, coin, "
       "saw",
       [](Json& json) {
         json["entities"] = Json::array({{{"kind", "dragon"}}});
       }},
      {"entities[0].x is missing",
       [](Json& json) {
         json["entities"] = Json::array({{{"kind", "saw"}}});
       }},
      {"entity of kind 15, which only cells can have",
       [](Json& json) {
         json["entities"] =
             Json::array({{{"kind", "ground"}, {"x", 9.5}, {"y", 9.5}, {"rx", 0.5}, {"ry", 0.5}}});
       }},
      {"entities[0].kind is 9223372036854775808, must be a name or in [0, 1100]",
       [](Json& json) {
         json["entities"] = Json::array({{{"kind", uint64_t{1} << 63}}});
       }},
      {"grid has 63 rows, the level has 64", [](Json& json) { json["grid"].erase(0); }},
      {"grid[3] has 63 cells, the level is 64 wide", [](Json& json) { json["grid"][3].erase(0); }},
      {"grid[3][4] is \"cheese\", coinrun has", [](Json& json) { json["grid"][3][4] = "cheese"; }},
      {"grid[0][0] is 20000, must be a name or in [0, 1100]",
       [](Json& json) { json["grid"][0][0] = 20000; }},
      {"the state has the unknown field coins; its fields are checksum, agent, entities, grid, "
       "game",
       [](Json& json) { json["coins"] = 3; }},
      {"no game is named \"pong\"", [](Json& json) { json["game"] = "pong"; }},
      {"options: distribution_mode is extreme (2), coinrun has easy, hard",
       [](Json& json) { json["options"]["distribution_mode"] = 2; }},
      {"level.world is missing", [](Json& json) { json["level"].erase("world"); }},
      {"checksum is \"none\", must be an integer", [](Json& json) { json["checksum"] = "none"; }},
      {"it has a null value", [](Json& json) { json["agent"]["x"] = nullptr; }},
  };
  for (const Rejected& rejected : all) {
    EXPECT_THAT(Edited("coinrun", rejected.change),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(rejected.message)));
  }
}

TEST(ReadableStateTest, TextThatIsNotTheJsonOfAStateIsRejected) {
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[]"), std::string("{}"), std::string("null"),
        std::string(100000, '['), R"({"game": "maze", "agent": )" + std::string(100, '[')}) {
    EXPECT_EQ(SnapshotFromJson(text).status().code(), absl::StatusCode::kInvalidArgument);
  }
}

// Random changes: what is accepted can be played, saved and restored.
TEST(ReadableStateTest, AcceptedEditsCanBePlayed) {
  RandomStream random(11);
  int accepted_count = 0;
  for (const GameSpec& game : GameCatalog()) {
    const Json original = JsonOf(Snapshot(game.name));
    const auto kinds = game.kinds;
    for (int change = 0; change < 25; ++change) {
      Json json = original;
      Json& grid = json["grid"];
      for (int i = 0; i < 20; ++i) {
        Json& row = grid[static_cast<size_t>(random.Int(static_cast<int32_t>(grid.size())))];
        const auto kind = static_cast<size_t>(random.Int(static_cast<int32_t>(kinds.size())));
        row[static_cast<size_t>(random.Int(static_cast<int32_t>(row.size())))] =
            std::string(kinds[kind].name);
      }
      json["agent"]["x"] = random.Range(0, static_cast<float>(grid[0].size()));
      json["agent"]["y"] = random.Range(0, static_cast<float>(grid.size()));
      if (!json["entities"].empty() && random.Coin()) {
        json["entities"].erase(json["entities"].size() - 1);
      }
      const auto snapshot = FromJson(json);
      if (!snapshot.ok()) {
        continue;
      }
      ++accepted_count;
      const auto environment = Environment::RestoreAny(*snapshot);
      ASSERT_THAT(environment, IsOk());
      for (int step = 0; step < 30; ++step) {
        TakeStep(**environment, random.Int(kActionCount));
      }
      ASSERT_THAT(Environment::RestoreAny((*environment)->SaveState().value()), IsOk());
    }
  }
  EXPECT_GT(accepted_count, 100);
}

}  // namespace
}  // namespace procgen
