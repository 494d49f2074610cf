// Last scenes of episodes, captured within a step.

#include <cstdint>
#include <memory>
#include <vector>

#include "envcore/pool/pool.h"
#include "envcore/pool/scene_snapshot.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"
#include "tests/envcore/pool/small_pool.h"

namespace procgen {
namespace {

std::vector<uint8_t> AgentViewOf(const SceneSnapshot& scene) {
  std::vector<uint8_t> frame(kObservationBytes);
  SceneSnapshotRenderer().DrawAgentView(scene, absl::MakeSpan(frame));
  return frame;
}

std::vector<uint8_t> FinalObservationOf(const BatchBuffers& buffers, size_t row) {
  return RowOf(buffers.final_observations, kObservationBytes, row);
}

class FinalSceneTest : public testing::TestWithParam<AutoresetMode> {
 protected:
  void SetUp() override {
    PoolOptions options = OptionsOf({"maze"});
    options.autoreset_mode = GetParam();
    pool_ = MadePool(options);
  }

  // Steps the environments [first, first + count).
  void Step(int32_t first, const std::vector<int32_t>& actions) {
    Batch batch = buffers_.Rows(first, static_cast<int32_t>(actions.size()));
    batch.final_scenes = absl::MakeSpan(scenes_);
    ASSERT_TRUE(
        pool_
            ->Step(
                {.first = first, .count = static_cast<int32_t>(actions.size()), .actions = actions},
                batch)
            .ok());
  }

  std::unique_ptr<Pool> pool_;
  BatchBuffers buffers_{kEnvCount};
  std::vector<FinalScene> scenes_ = {{.environment = 1, .scene = nullptr},
                                     {.environment = 3, .scene = nullptr}};
};

TEST_P(FinalSceneTest, IsCapturedBeforeTheNewLevel) {
  Step(0, {7, 7, 7, 7});
  EXPECT_EQ(scenes_[0].scene, nullptr);
  EXPECT_EQ(scenes_[1].scene, nullptr);
  Step(0, {7, 7, kEndEpisodeAction, kEndEpisodeAction});
  EXPECT_EQ(scenes_[0].scene, nullptr);
  ASSERT_NE(scenes_[1].scene, nullptr);
  EXPECT_EQ(AgentViewOf(*scenes_[1].scene), FinalObservationOf(buffers_, 3));
}

TEST_P(FinalSceneTest, BelongsToTheEnvironmentInASlice) {
  Step(2, {kEndEpisodeAction, kEndEpisodeAction});
  EXPECT_EQ(scenes_[0].scene, nullptr);
  ASSERT_NE(scenes_[1].scene, nullptr);
  EXPECT_EQ(AgentViewOf(*scenes_[1].scene), FinalObservationOf(buffers_, 3));
}

INSTANTIATE_TEST_SUITE_P(Modes, FinalSceneTest,
                         testing::Values(AutoresetMode::kSameStep, AutoresetMode::kNextStep,
                                         AutoresetMode::kDisabled));

}  // namespace
}  // namespace procgen
