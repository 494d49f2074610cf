// The roles of the parts of each game, from the specification. Sizes are those of entities and
// cells on the screen.

#include "tools/art/roles.h"

#include <algorithm>
#include <iterator>

namespace procgen {
namespace {

constexpr Part kBigFish[] = {
    {"agent", Role::kAgent, {0}},
    // At the size of the agent; other fish can be distinguished by size.
    {"fish", Role::kKills, {2}, 1, 1, true},
};

constexpr Part kBossFight[] = {
    {"agent", Role::kAgent, {0}, 1.5F, 1.5F, true},
    {"player bullet", Role::kHarmless, {1}, 0.5F, 0.5F},
    {"boss", Role::kKills, {2}, 6, 6, true},
    {"shield", Role::kBlocks, {3}, 7.2F, 7.2F, true},
    {"boss bullet", Role::kKills, {4}},
    {"meteor", Role::kKills, {7}, 1.2F, 1.2F, true},
};

constexpr Part kCaveFlyer[] = {
    {"ship", Role::kAgent, {0}, 0.8F, 0.8F},
    {"green saucer", Role::kPays, {1}},
    {"meteor", Role::kKills, {2}},
    {"red saucer", Role::kKills, {3}},
    {"shot", Role::kHarmless, {4}, 0.2F, 0.5F},
    {"enemy ship", Role::kKills, {5}},
    {"cave wall", Role::kBlocks, {8}},
};

constexpr Part kChaser[] = {
    {"agent", Role::kAgent, {0}},
    {"large orb", Role::kPays, {2}, 0.8F, 0.8F},
    {"small orb", Role::kPays, {kDotImage}},
    {"edible enemy", Role::kPays, {3}},
    {"egg", Role::kHarmless, {4}},
    {"wall", Role::kBlocks, {5}},
    {"enemy", Role::kKills, {6, 7, 8}},
};

constexpr Part kClimber[] = {
    {"player", Role::kAgent, {0, 9, 12, 13}},   {"crystal", Role::kPays, {1}, 0.6F, 0.6F},
    {"fish", Role::kKills, {6, 7}, 1, 1, true}, {"rock", Role::kBlocks, {15}},
    {"platform", Role::kBlocks, {16}},
};

constexpr Part kCoinRun[] = {
    {"player", Role::kAgent, {0, 12, 13}, 1, 2},
    {"coin", Role::kPays, {1}},
    {"saw", Role::kKills, {2, 3}},
    {"walker", Role::kKills, {6, 7}},
    {"ground", Role::kBlocks, {15}},
    {"top of the ground", Role::kBlocks, {16}},
    {"lava", Role::kKills, {17}},
    {"top of the lava", Role::kKills, {18}},
    {"crate", Role::kBlocks, {20}},
};

constexpr Part kDodgeball[] = {
    {"thrower", Role::kAgent, {0}, 0.8F, 0.8F},
    {"lava", Role::kKills, {1}, 0.6F, 0.6F},
    {"ball", Role::kHarmless, {3}, 0.5F, 0.5F},
    {.name = "enemy", .role = Role::kKills, .image_kinds = {4}, .last_theme = 6},
    {"enemy's ball", Role::kKills, {6}, 0.5F, 0.5F},
    {"closed door", Role::kNamed, {5}, 1.5F, 1.5F},
    {"open door", Role::kNamed, {7}, 1.5F, 1.5F},
    {"outside", Role::kBlocks, {10}},
};

constexpr Part kFruitBot[] = {
    {"robot", Role::kAgent, {0}, 0.8F, 0.8F},
    {"wall", Role::kKills, {1}, 0.6F, 0.6F},
    {"stone", Role::kBlocks, {2}},
    {"key", Role::kHarmless, {3}, 0.5F, 0.5F},
    {"food", Role::kKills, {4}, 1, 1, true},
    {"fruit", Role::kPays, {7}, 1, 1, true},
    {"door", Role::kNamed, {10}, 2, 0.6F, true},
    {"lock", Role::kNamed, {11}, 0.5F, 0.9F},
    {"present", Role::kPays, {12}},
};

constexpr Part kHeist[] = {
    {"thief", Role::kAgent, {0}, 0.8F, 0.8F},
    {"lock 0", Role::kNamed, {1}, 1, 1, false, 0, 0},
    {"lock 1", Role::kNamed, {1}, 1, 1, false, 1, 1},
    {"lock 2", Role::kNamed, {1}, 1, 1, false, 2, 2},
    {"key 0", Role::kNamed, {2}, 0.8F, 0.8F, true, 0, 0},
    {"key 1", Role::kNamed, {2}, 0.8F, 0.8F, true, 1, 1},
    {"key 2", Role::kNamed, {2}, 0.8F, 0.8F, true, 2, 2},
    {"gem", Role::kPays, {9}, 0.8F, 0.8F, true},
    {"wall", Role::kBlocks, {51}},
};

constexpr Part kJumper[] = {
    {"bunny", Role::kAgent, {0, 10, 11, 12, 13}, 0.8F, 0.8F, true},
    {"carrot", Role::kPays, {1}},
    {"spike man", Role::kKills, {2}, 0.8F, 0.8F, true},
    {"rock", Role::kBlocks, {6}},
    {"ground", Role::kBlocks, {7}},
};

constexpr int kLeaperLog = 1;
constexpr int kLeaperRoad = 2;
constexpr int kLeaperWater = 3;
constexpr Part kLeaper[] = {
    {.name = "frog",
     .role = Role::kAgent,
     .image_kinds = {0},
     .width = 1.25F,
     .height = 1.25F,
     .keeps_ratio = true,
     .backdrops = {kBackgroundBackdrop, kLeaperRoad, kLeaperLog}},
    {.name = "log",
     .role = Role::kHarmless,
     .image_kinds = {kLeaperLog},
     .width = 0.9F,
     .height = 0.9F,
     .backdrops = {kLeaperWater}},
    {"road", Role::kHarmless, {kLeaperRoad}},
    {"water", Role::kKills, {kLeaperWater}},
    {.name = "car",
     .role = Role::kKills,
     .image_kinds = {4},
     .keeps_ratio = true,
     .backdrops = {kLeaperRoad}},
    {"finish", Role::kPays, {5}},
};

constexpr Part kMaze[] = {
    {"mouse", Role::kAgent, {0}},
    {"cheese", Role::kPays, {2}},
    {"wall", Role::kBlocks, {51}},
};

constexpr Part kMiner[] = {
    {"robot", Role::kAgent, {0}}, {"boulder", Role::kKills, {1}}, {"diamond", Role::kNamed, {2}},
    {"exit", Role::kNamed, {6}},  {"dirt", Role::kHarmless, {9}}, {"bricks", Role::kBlocks, {10}},
};

constexpr Part kNinja[] = {
    {"ninja", Role::kAgent, {0, 12, 13}}, {"mushroom", Role::kPays, {1}},
    {"bomb", Role::kKills, {6}},          {"star", Role::kHarmless, {7}, 0.5F, 0.5F},
    {"fire", Role::kKills, {14}},         {"bricks", Role::kBlocks, {20}},
};

// The player's ship has one of these images; its position distinguishes it.
constexpr Part kPlunder[] = {
    {"cannon ball", Role::kHarmless, {1}, 0.5F, 0.5F},
    {"panel", Role::kBlocks, {6}, 2.4F, 1},
    {"ship 0", Role::kNamed, {7}, 2, 2, true, 0, 0},
    {"ship 1", Role::kNamed, {7}, 2, 2, true, 1, 1},
    {"ship 2", Role::kNamed, {7}, 2, 2, true, 2, 2},
    {"ship 3", Role::kNamed, {7}, 2, 2, true, 3, 3},
    {"ship 4", Role::kNamed, {7}, 2, 2, true, 4, 4},
    {"ship 5", Role::kNamed, {7}, 2, 2, true, 5, 5},
};

constexpr Part kStarPilot[] = {
    {"agent", Role::kAgent, {0}, 0.8F, 0.8F},
    {"player bullet", Role::kHarmless, {1}, 0.8F, 0.8F},
    {"flyer's bullet", Role::kKills, {2}, 0.8F, 0.8F},
    {"turret's bullet", Role::kKills, {3}, 0.8F, 0.8F},
    {"flyer", Role::kKills, {4, 8}},
    {"meteor", Role::kKills, {5}, 4, 4},
    {"cloud", Role::kHarmless, {6}, 4, 4},
    {"turret", Role::kKills, {7}, 4, 4, true},
    {"rocket", Role::kPays, {9}, 16, 16, true},
};

constexpr Roles kRoles[] = {
    {"bigfish", DistributionMode::kHard, kBigFish},
    {"bossfight", DistributionMode::kHard, kBossFight},
    {"caveflyer", DistributionMode::kHard, kCaveFlyer},
    {"chaser", DistributionMode::kExtreme, kChaser},
    {"climber", DistributionMode::kHard, kClimber},
    {"coinrun", DistributionMode::kHard, kCoinRun},
    {"dodgeball", DistributionMode::kExtreme, kDodgeball},
    {"fruitbot", DistributionMode::kHard, kFruitBot},
    {"heist", DistributionMode::kHard, kHeist},
    {"jumper", DistributionMode::kHard, kJumper},
    {"leaper", DistributionMode::kExtreme, kLeaper},
    {"maze", DistributionMode::kHard, kMaze},
    {"miner", DistributionMode::kHard, kMiner},
    {"ninja", DistributionMode::kHard, kNinja},
    {"plunder", DistributionMode::kHard, kPlunder},
    {"starpilot", DistributionMode::kHard, kStarPilot},
};

}  // namespace

absl::string_view RoleName(Role role) {
  constexpr absl::string_view kNames[] = {"agent", "kills", "pays", "blocks", "harmless", "named"};
  return kNames[static_cast<size_t>(role)];
}

absl::Span<const Roles> AllRoles() { return kRoles; }

const Roles& RolesOf(absl::string_view game) {
  return *std::find_if(std::begin(kRoles), std::end(kRoles),
                       [&](const Roles& roles) { return roles.game == game; });
}

bool MustDiffer(const Part& a, const Part& b) { return a.role != b.role || a.role == Role::kNamed; }

}  // namespace procgen
