#include "envcore/games/game_kind_names.h"

#include <vector>

#include "absl/strings/str_join.h"
#include "envcore/world/kinds.h"

namespace procgen {
namespace {

struct GameKinds {
  absl::string_view game;
  absl::Span<const KindName> kinds;
};

constexpr KindName kCommon[] = {{kAgentKind, "agent"},
                                {kWallKind, "wall"},
                                {kExplosionKind, "explosion"},
                                {kTrailKind, "trail"},
                                {kEmptyKind, "empty"}};

// The numbers are the k...Kind of the games' files, which never change (kinds.h).
constexpr KindName kBigFish[] = {{2, "fish"}};
constexpr KindName kBossFight[] = {
    {1, "player_bullet"},    {2, "boss"},  {3, "shield"}, {4, "boss_bullet"}, {5, "bullet_trail"},
    {6, "reflected_bullet"}, {7, "meteor"}};
constexpr KindName kCaveFlyer[] = {
    {1, "goal_saucer", true}, {2, "meteor"},    {3, "red_saucer"}, {4, "shot"},
    {5, "enemy_ship"},        {8, "cave_wall"}, {9, "exhaust"}};
constexpr KindName kChaser[] = {
    {2, "large_orb"}, {4, "egg"}, {5, "maze_wall"}, {6, "enemy"}, {1002, "small_orb"}};
constexpr KindName kClimber[] = {{1, "crystal", true}, {5, "fish"}, {15, "rock"}, {16, "platform"}};
constexpr KindName kCoinRun[] = {{1, "coin", true},    {2, "saw"},         {5, "walker"},
                                 {15, "ground"},       {16, "ground_top"}, {17, "lava"},
                                 {18, "lava_surface"}, {19, "barrier"},    {20, "crate"}};
constexpr KindName kDodgeball[] = {{1, "lava"},       {3, "ball"},       {4, "enemy"},
                                   {5, "door", true}, {6, "enemy_ball"}, {8, "cloud"},
                                   {10, "outside"}};
constexpr KindName kFruitBot[] = {{1, "barrier"}, {2, "stone"},         {3, "key"},
                                  {4, "food"},    {7, "fruit"},         {10, "door"},
                                  {11, "lock"},   {12, "present", true}};
constexpr KindName kHeist[] = {{1, "lock"}, {2, "key"}, {9, "gem", true}, {11, "key_display"}};
constexpr KindName kJumper[] = {{1, "carrot", true}, {2, "spike_man"}, {6, "rock"}, {7, "ground"}};
constexpr KindName kLeaper[] = {
    {1, "log"}, {2, "road"}, {3, "water"}, {4, "car"}, {5, "finish", true}};
constexpr KindName kMaze[] = {{2, "cheese", true}, {3, "decoy"}};
constexpr KindName kMiner[] = {{1, "boulder"},         {2, "diamond"},    {3, "falling_boulder"},
                               {4, "falling_diamond"}, {6, "exit", true}, {9, "dirt"},
                               {10, "bricks"}};
constexpr KindName kNinja[] = {
    {1, "mushroom", true}, {6, "bomb"}, {7, "star"}, {14, "fire"}, {20, "bricks"}};
constexpr KindName kPlunder[] = {
    {1, "cannon_ball"}, {2, "target_sign"}, {3, "target_disc"}, {6, "panel"}, {7, "ship"}};
constexpr KindName kStarPilot[] = {{1, "player_bullet"}, {2, "flyer_bullet"}, {3, "turret_bullet"},
                                   {4, "flyer"},         {5, "meteor"},       {6, "cloud"},
                                   {7, "turret"},        {8, "fast_flyer"},   {9, "rocket"}};

constexpr GameKinds kGames[] = {
    {"bigfish", kBigFish},     {"bossfight", kBossFight}, {"caveflyer", kCaveFlyer},
    {"chaser", kChaser},       {"climber", kClimber},     {"coinrun", kCoinRun},
    {"dodgeball", kDodgeball}, {"fruitbot", kFruitBot},   {"heist", kHeist},
    {"jumper", kJumper},       {"leaper", kLeaper},       {"maze", kMaze},
    {"miner", kMiner},         {"ninja", kNinja},         {"plunder", kPlunder},
    {"starpilot", kStarPilot}};

}  // namespace

absl::Span<const KindName> CommonKindNames() { return kCommon; }

absl::Span<const KindName> KindNamesOf(absl::string_view game) {
  for (const GameKinds& each : kGames) {
    if (each.game == game) {
      return each.kinds;
    }
  }
  return {};
}

absl::string_view NameOfKind(absl::string_view game, int kind) {
  for (const absl::Span<const KindName> kinds : {KindNamesOf(game), CommonKindNames()}) {
    for (const KindName& each : kinds) {
      if (each.kind == kind) {
        return each.name;
      }
    }
  }
  return "";
}

std::optional<int> FindKind(absl::string_view game, absl::string_view name) {
  for (const absl::Span<const KindName> kinds : {KindNamesOf(game), CommonKindNames()}) {
    for (const KindName& each : kinds) {
      if (each.name == name) {
        return each.kind;
      }
    }
  }
  return std::nullopt;
}

std::string AllKindNames(absl::string_view game) {
  std::vector<absl::string_view> names;
  for (const absl::Span<const KindName> kinds : {CommonKindNames(), KindNamesOf(game)}) {
    for (const KindName& each : kinds) {
      names.push_back(each.name);
    }
  }
  return absl::StrJoin(names, ", ");
}

}  // namespace procgen
