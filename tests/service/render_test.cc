// Rendering environments for people.

#include <string>
#include <vector>

#include "envcore/render/art/png_decoding.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class RenderTest : public ServiceTest {};

TEST_F(RenderTest, PngFilesShowTheSamePixels) {
  const auto stream = StartPool(MazeSpec(1));
  const auto raw = stream->Render({0}, 100);
  const auto file = stream->Render({0}, 100, v1::FRAME_FORMAT_PNG);
  ASSERT_THAT(raw, IsOk());
  ASSERT_THAT(file, IsOk());
  const auto image = DecodePng(file->frames(0).image(), AlphaUse::kIgnored);
  ASSERT_THAT(image, IsOk());
  std::string pixels;
  for (int y = 0; y < image->height(); ++y) {
    for (int x = 0; x < image->width(); ++x) {
      const Rgba& pixel = image->At(x, y);
      for (const uint8_t channel : {pixel.red, pixel.green, pixel.blue}) {
        pixels.push_back(static_cast<char>(channel));
      }
    }
  }
  EXPECT_TRUE(pixels == raw->frames(0).image());
}

TEST_F(RenderTest, AgentViewEqualsObservationsInEveryFormat) {
  const auto plain = StartPool(MazeSpec(1));
  v1::Batch batch;
  ASSERT_THAT(plain->Step({5}, &batch), IsOk());
  v1::PoolSpec spec = MazeSpec(1);
  spec.mutable_observation_format()->set_color(v1::COLOR_GRAYSCALE);
  const auto grey = StartPool(spec);
  v1::Batch grey_batch;
  ASSERT_THAT(grey->Step({5}, &grey_batch), IsOk());
  for (PoolStream* stream : {plain.get(), grey.get()}) {
    const auto frames = stream->Render({0}, 0, v1::FRAME_FORMAT_RGB, v1::FRAME_VIEW_AGENT);
    ASSERT_THAT(frames, IsOk());
    EXPECT_TRUE(frames->frames(0).image() == batch.observations());
    EXPECT_EQ(frames->frames(0).size_px(), 64);
  }
  EXPECT_THAT(plain->Render({0}, 128, v1::FRAME_FORMAT_RGB, v1::FRAME_VIEW_AGENT),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "size_px is 128, allowed with FRAME_VIEW_AGENT: 64"));
}

TEST_F(RenderTest, LevelViewShowsWhatACameraDoesThatDoesNotFollowTheAgent) {
  v1::PoolSpec spec;
  spec.add_games("coinrun");
  spec.set_env_count(1);
  spec.mutable_options()->set_rand_seed(5);
  const auto centered = StartPool(spec);
  spec.mutable_options()->set_center_agent(false);
  const auto whole = StartPool(spec);
  const auto level = centered->Render({0}, 200, v1::FRAME_FORMAT_RGB, v1::FRAME_VIEW_LEVEL);
  const auto seen = centered->Render({0}, 200);
  const auto expected = whole->Render({0}, 200);
  ASSERT_THAT(level, IsOk());
  ASSERT_THAT(seen, IsOk());
  ASSERT_THAT(expected, IsOk());
  EXPECT_TRUE(level->frames(0).image() == expected->frames(0).image());
  EXPECT_FALSE(level->frames(0).image() == seen->frames(0).image());
  const auto by_default = centered->Render({0}, 0, v1::FRAME_FORMAT_RGB, v1::FRAME_VIEW_LEVEL);
  ASSERT_THAT(by_default, IsOk());
  EXPECT_EQ(by_default->frames(0).size_px(), 512);
}

TEST_F(RenderTest, TheAgentIsWhereTheImageOfTheLevelShowsIt) {
  const auto stream = StartPool(MazeSpec(1));
  const auto images = stream->Render({0}, 256, v1::FRAME_FORMAT_RGB, v1::FRAME_VIEW_LEVEL);
  const auto positions = stream->Render({0}, 0, v1::FRAME_FORMAT_NONE, v1::FRAME_VIEW_LEVEL);
  ASSERT_THAT(images, IsOk());
  ASSERT_THAT(positions, IsOk());
  ASSERT_TRUE(images->frames(0).has_agent_position());
  EXPECT_EQ(images->frames(0).image().size(), 256U * 256 * 3);
  EXPECT_EQ(positions->frames(0).image(), "");
  const v1::AgentPosition& before = positions->frames(0).agent_position();
  EXPECT_EQ(before.x(), images->frames(0).agent_position().x());
  // The agent of maze starts in the lower left cell, moves by one cell, and x is to the right.
  EXPECT_LT(before.x(), 0.5);
  EXPECT_GT(before.y(), 0.5);
  v1::Batch batch;
  for (const int32_t action : {7, 5, 7, 5}) {  // right or up: the maze has one way from the corner
    ASSERT_THAT(stream->Step({action}, &batch), IsOk());
  }
  const auto moved = stream->Render({0}, 0, v1::FRAME_FORMAT_NONE, v1::FRAME_VIEW_LEVEL);
  ASSERT_THAT(moved, IsOk());
  const v1::AgentPosition& after = moved->frames(0).agent_position();
  EXPECT_GE(after.x(), before.x());
  EXPECT_LE(after.y(), before.y());
  EXPECT_GT(after.x() - before.x() + before.y() - after.y(), 0.01);
  const auto human = stream->Render({0}, 64);
  ASSERT_THAT(human, IsOk());
  EXPECT_FALSE(human->frames(0).has_agent_position());
}

}  // namespace
}  // namespace procgen
