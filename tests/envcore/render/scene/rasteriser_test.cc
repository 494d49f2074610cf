#include "envcore/render/scene/rasteriser.h"

#include <cstdint>
#include <vector>

#include "envcore/level/generated_art.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

constexpr int kSizePx = 64;
constexpr uint32_t kArtSeed = 5;

class RasteriserTest : public ::testing::Test {
 protected:
  RasteriserTest() : art_(ArtPack::Embedded(), "test", {}, kArtSeed, {}) {
    for (size_t kind = 0; kind < scene_.cells.looks.size(); ++kind) {
      scene_.cells.looks[kind].image_kind = static_cast<int16_t>(kind);
    }
    scene_.camera = {8, 8, 16};
    scene_.world_width = 16;
    scene_.world_height = 16;
    scene_.art_style = ArtStyle::kMonochrome;
  }

  std::vector<uint8_t> AgentView() {
    std::vector<uint8_t> frame(kSizePx * kSizePx * 3, 99);
    rasteriser_.DrawAgentView(scene_, art_, nullptr, {}, absl::MakeSpan(frame));
    return frame;
  }

  Rasteriser rasteriser_;
  GameArt art_;
  Scene scene_;
};

TEST_F(RasteriserTest, PixelsOutsideTheBackgroundAreBlackAgain) {
  scene_.above_cells.push_back({.x = 8, .y = 8, .rx = 8, .ry = 8});
  EXPECT_THAT(AgentView(), ::testing::Not(::testing::Contains(0)));
  scene_.above_cells.clear();
  scene_.art_style = ArtStyle::kPictures;
  scene_.background = {.shown = true, .group = BackgroundGroup::kWater, .tile_ratio = 1};
  scene_.world_width = 8;
  scene_.world_height = 4;
  const std::vector<uint8_t> frame = AgentView();
  int lit = 0;
  for (int y = 0; y < kSizePx; ++y) {
    for (int x = 0; x < kSizePx; ++x) {
      const bool inside = x < 32 && y >= 48;
      const int blue = (y * kSizePx + x) * 3 + 2;
      const bool is_lit = frame[static_cast<size_t>(blue)] != 0;
      EXPECT_FALSE(is_lit && !inside) << x << ", " << y;
      lit += is_lit ? 1 : 0;
    }
  }
  EXPECT_EQ(lit, 32 * 16) << "water is blue";
}

// Sprites that touch no rows, a few or many; upright and rotated; with overlays.
TEST_F(RasteriserTest, AStaticLayerChangesNoPixel) {
  scene_.art_style = ArtStyle::kPictures;
  scene_.background = {.shown = true, .group = BackgroundGroup::kWater};
  const std::vector<Overlay> overlays = {
      {.shape = Overlay::Shape::kRectangle, .x = 1, .y = 2, .width = 5, .height = 0.6F},
      {.shape = Overlay::Shape::kNeedle, .x = 8, .y = 8, .width = 6, .height = 2, .angle = 2},
      {.shape = Overlay::Shape::kJumpMark, .x = 4, .y = 4, .width = 2, .height = 2}};
  for (const FrameFormat& format :
       {FrameFormat{}, FrameFormat{.layout = Layout::kChw}, FrameFormat{.size_px = 84},
        FrameFormat{.color = Color::kGrayscale}}) {
    StaticLayerCache static_layer;
    std::vector<uint8_t> frame(format.bytes());
    std::vector<uint8_t> expected(format.bytes());
    for (int step = 0; step < 60; ++step) {
      const auto along = static_cast<float>(step) * 0.37F;
      scene_.above_cells.assign({{.x = along, .y = 15.5F - along, .rx = 0.4F, .ry = 0.7F},
                                 {.x = 9, .y = along - 2, .rx = 2, .ry = 0.3F, .rotation = along},
                                 {.x = 8, .y = 17.3F, .rx = 2, .ry = 0.5F, .image_kind = 2}});
      scene_.overlays.clear();
      if (step % 4 > 0) {
        scene_.overlays.push_back(overlays[static_cast<size_t>(step % 4) - 1]);
      }
      scene_.velocity.shown = step % 5 == 0;
      rasteriser_.DrawAgentView(scene_, art_, &static_layer, format, absl::MakeSpan(frame));
      rasteriser_.DrawAgentView(scene_, art_, nullptr, format, absl::MakeSpan(expected));
      ASSERT_EQ(frame, expected) << "step " << step << ", side " << format.size_px;
    }
  }
}

// A box of 2 x 1 cells of the 16 in view, with its upper left corner at (1, 0.5).
TEST_F(RasteriserTest, SpritesScaleWithTheRequestedSize) {
  scene_.above_cells.push_back({.x = 2, .y = 15, .rx = 1, .ry = 0.5F});
  struct Box {
    int side, left, top, right, bottom;
  };
  for (const Box& box : {Box{16, 1, 1, 3, 2}, Box{64, 4, 2, 12, 6}, Box{84, 5, 3, 16, 8},
                         Box{512, 32, 16, 96, 48}}) {
    const FrameFormat format = {.size_px = box.side, .color = Color::kGrayscale};
    std::vector<uint8_t> frame(format.bytes());
    rasteriser_.DrawAgentView(scene_, art_, nullptr, format, absl::MakeSpan(frame));
    for (int y = 0; y < box.side; ++y) {
      for (int x = 0; x < box.side; ++x) {
        const bool inside = x >= box.left && x < box.right && y >= box.top && y < box.bottom;
        ASSERT_EQ(frame[static_cast<size_t>(y * box.side + x)] != 0, inside)
            << x << ", " << y << " of " << box.side;
      }
    }
  }
}

TEST_F(RasteriserTest, FramesDoNotDependOnEarlierFrames) {
  RandomStream random(1);
  std::vector<GeneratedArt> levels;
  levels.reserve(12);
  for (int i = 0; i < 12; ++i) {
    levels.push_back(GenerateBackground(random));
  }
  const auto draw = [&](const GeneratedArt& level) {
    scene_.background = {.shown = true, .generated = &level};
    return AgentView();
  };
  std::vector<std::vector<uint8_t>> frames;
  frames.reserve(levels.size());
  for (const GeneratedArt& level : levels) {
    frames.push_back(draw(level));
  }
  for (size_t i = levels.size(); i-- > 0;) {
    EXPECT_EQ(draw(levels[i]), frames[i]);
  }
}

TEST_F(RasteriserTest, HumanViewHasAnySize) {
  scene_.background = {.shown = true, .group = BackgroundGroup::kWater};
  for (const int32_t side : {16, 333, 2048}) {
    std::vector<uint8_t> frame(static_cast<size_t>(side) * static_cast<size_t>(side) * 3);
    rasteriser_.DrawHumanView(scene_, art_, side, absl::MakeSpan(frame));
    // A pixel in the middle has a color.
    EXPECT_THAT(absl::MakeConstSpan(frame).subspan(frame.size() / 2, 3),
                ::testing::Not(::testing::Each(0)))
        << side;
  }
}

}  // namespace
}  // namespace procgen
