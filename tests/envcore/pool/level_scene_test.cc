// Scenes of whole levels.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "envcore/games/game_catalog.h"
#include "envcore/pool/pool.h"
#include "envcore/pool/scene_snapshot.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"
#include "tests/envcore/pool/small_pool.h"

namespace procgen {
namespace {

constexpr int32_t kSizePx = 96;
constexpr int32_t kStepCount = 20;

// A pool of one environment after some steps.
std::unique_ptr<Pool> PlayedPool(const std::string& game, DistributionMode mode,
                                 bool center_agent) {
  PoolOptions options = OptionsOf({game}, 1);
  options.environment.distribution_mode = mode;
  options.environment.rand_seed = 3;
  options.environment.center_agent = center_agent;
  std::unique_ptr<Pool> pool = MadePool(options);
  BatchBuffers buffers(1);
  for (int32_t step = 0; step < kStepCount; ++step) {
    const int32_t action = step % 3 == 0 ? 8 : 7;
    EXPECT_TRUE(pool->Step({.count = 1, .actions = {&action, 1}}, buffers.Whole()).ok());
  }
  return pool;
}

std::vector<uint8_t> Drawn(Pool& pool, bool whole_level) {
  const auto scene = pool.CaptureScene(0, whole_level);
  EXPECT_TRUE(scene.ok()) << scene.status();
  std::vector<uint8_t> frame(size_t{3} * kSizePx * kSizePx);
  SceneSnapshotRenderer().DrawHumanView(*scene, kSizePx, absl::MakeSpan(frame));
  return frame;
}

TEST(LevelSceneTest, IsWhatACameraShowsThatDoesNotFollowTheAgent) {
  for (const GameSpec& game : GameCatalog()) {
    const std::string name(game.name);
    for (const DistributionMode mode : game.modes) {
      SCOPED_TRACE(name + " " + std::string(DistributionModeName(mode)));
      const std::unique_ptr<Pool> pool = PlayedPool(name, mode, /*center_agent=*/true);
      const std::vector<uint8_t> seen = Drawn(*pool, /*whole_level=*/false);
      const std::vector<uint8_t> level = Drawn(*pool, /*whole_level=*/true);
      EXPECT_EQ(Drawn(*pool, /*whole_level=*/false), seen);  // nothing has changed
      if (mode == DistributionMode::kMemory) {
        EXPECT_NE(level, seen);  // there, the camera always follows the agent
      } else {
        EXPECT_EQ(level, Drawn(*PlayedPool(name, mode, /*center_agent=*/false), false));
      }
    }
  }
}

}  // namespace
}  // namespace procgen
