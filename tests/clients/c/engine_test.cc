// Pools behind the C ABI give what the engine gives.

#include <cstdint>
#include <vector>

#include "envcore/games/game_catalog.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/clients/c/c_pool.h"
#include "tests/envcore/pool/small_pool.h"

namespace procgen {
namespace {

constexpr int32_t kSteps = 60;

// The engine's batch, with the fingerprints of ended episodes only.
BatchBuffers WithFingerprintsOfEnds(BatchBuffers buffers) {
  for (size_t row = 0; row < buffers.fingerprints.size(); ++row) {
    if (buffers.terminated[row] == 0 && buffers.truncated[row] == 0) {
      buffers.fingerprints[row] = 0;
    }
  }
  return buffers;
}

class EngineTest : public testing::TestWithParam<int32_t> {};

TEST_P(EngineTest, EveryGameAndModeEqualsTheEngine) {
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : game.modes) {
      COptions options(game.name.data(), 3);
      options.distribution_mode = static_cast<int32_t>(mode);
      options.num_threads = GetParam();
      const CPool pool = Made(options);
      PoolOptions engine_options = OptionsOf({std::string(game.name)}, 3);
      engine_options.environment.distribution_mode = mode;
      engine_options.environment.rand_seed = 7;
      const std::unique_ptr<Pool> engine = MadePool(engine_options);
      const std::vector<BatchBuffers> batches = Steps(pool.get(), 3, 0, kSteps);
      for (int32_t t = 0; t < kSteps; ++t) {
        ASSERT_EQ(batches[static_cast<size_t>(t)],
                  WithFingerprintsOfEnds(Stepped(*engine, ActionsAt(t, 3))))
            << game.name << " " << DistributionModeName(mode) << " step " << t;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Threads, EngineTest, testing::Values(0, 2),
                         [](const auto& info) { return "Threads" + std::to_string(info.param); });

TEST(EngineOptionsTest, EachOptionReachesTheEngine) {
  COptions options("coinrun", 2);
  options.start_level = 3;
  options.num_levels = 2;
  options.use_sequential_levels = 1;
  options.center_agent = 0;
  options.use_backgrounds = 0;
  options.use_monochrome_assets = 1;
  options.restrict_themes = 1;
  options.paint_vel_info = 1;
  options.debug_mode = 1;
  options.screen_size = 32;
  options.grayscale_obs = 1;
  options.layout = PROCGEN_CHW;
  options.frame_stack = 3;
  options.first_env = 1;
  options.total_env_count = 5;
  const CPool pool = Made(options);
  ProcgenPoolInfo info = {};
  info.struct_size = sizeof(info);
  ASSERT_EQ(procgen_pool_info(pool.get(), &info), PROCGEN_OK);
  EXPECT_EQ(info.env_count, 2);
  EXPECT_EQ(info.rand_seed, 7);
  EXPECT_THAT(std::vector<int32_t>(info.observation_shape, info.observation_shape + 4),
              testing::ElementsAre(3, 1, 32, 32));
  EXPECT_EQ(info.observation_rank, 4);
  EXPECT_EQ(info.observation_bytes, 3 * 32 * 32);

  PoolOptions expected = OptionsOf({"coinrun"}, 2);
  expected.environment.rand_seed = 7;
  expected.environment.start_level = 3;
  expected.environment.num_levels = 2;
  expected.environment.use_sequential_levels = true;
  expected.environment.center_agent = false;
  expected.environment.use_backgrounds = false;
  expected.environment.use_monochrome_assets = true;
  expected.environment.restrict_themes = true;
  expected.environment.paint_vel_info = true;
  expected.environment.debug_mode = 1;
  expected.observation_format.frame = {
      .size_px = 32, .color = Color::kGrayscale, .layout = Layout::kChw};
  expected.observation_format.frame_stack = 3;
  expected.first_env = 1;
  expected.total_env_count = 5;
  const std::unique_ptr<Pool> engine = MadePool(expected);
  for (int32_t t = 0; t < kSteps; ++t) {
    const std::vector<int32_t> actions = ActionsAt(t, 2);
    const ProcgenStep step = StepOf(actions);
    BatchBuffers buffers(2, static_cast<size_t>(info.observation_bytes));
    const ProcgenBatch batch = BatchIn(buffers);
    ASSERT_EQ(procgen_step(pool.get(), &step, &batch), PROCGEN_OK);
    ASSERT_EQ(buffers, WithFingerprintsOfEnds(Stepped(*engine, actions)));
  }
}

}  // namespace
}  // namespace procgen
