#include "envcore/render/scene/static_layer_cache.h"

#include <functional>
#include <vector>

#include "envcore/level/generated_art.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;
using Use = StaticLayerCache::Use;

class StaticLayerCacheTest : public ::testing::Test {
 protected:
  StaticLayerCacheTest() {
    grid_.Reset(8, 6, kEmptyKind);
    scene_.camera = {4, 3, 8};
    scene_.world_width = 8;
    scene_.world_height = 6;
    scene_.background.shown = true;
    scene_.cells.grid = &grid_;
    scene_.cells.first_column = -1;
    scene_.cells.last_column = 8;
    scene_.cells.first_row = 2;
    scene_.cells.last_row = 9;
  }

  // Repeats the scene until the layer is kept.
  void Keep() {
    layer_.Classify(scene_);
    layer_.Classify(scene_);
    ASSERT_EQ(layer_.Classify(scene_), Use::kKeep);
    layer_.Keep(frame_.frame());
    ASSERT_EQ(layer_.Classify(scene_), Use::kCopy);
  }

  Grid grid_;
  Scene scene_;
  StaticLayerCache layer_;
  TextFrame frame_{4};
};

TEST_F(StaticLayerCacheTest, ALayerUsedThreeTimesIsCached) {
  EXPECT_EQ(layer_.Classify(scene_), Use::kDrawOnly);
  EXPECT_EQ(layer_.Classify(scene_), Use::kDrawOnly);
  EXPECT_EQ(layer_.Classify(scene_), Use::kKeep);
  *frame_.frame().At(3, 2) = {'k', 0, 0, 255};
  layer_.Keep(frame_.frame());
  EXPECT_EQ(layer_.Classify(scene_), Use::kCopy);
  TextFrame other(4);
  layer_.CopyRows(0, 4, other.frame());
  EXPECT_EQ(other.Text(), frame_.Text());
  EXPECT_THAT(layer_.Rows(2, 3), ElementsAre(0, 0, 0, 0, 0, 0, 0, 0, 0, 'k', 0, 0));
}

TEST_F(StaticLayerCacheTest, EveryChangeIsDetected) {
  const std::vector<std::function<void()>> changes = {
      [&] { scene_.camera.center_x += 0.25F; },
      [&] { scene_.camera.cells = 9; },
      [&] { scene_.world_width = 9; },
      [&] { scene_.world_height = 9; },
      [&] { scene_.art_style = ArtStyle::kMonochrome; },
      [&] { scene_.background.index = 3; },
      [&] { scene_.background.offset = 0.5F; },
      [&] { scene_.background.scrolled_steps = 1; },
      [&] { scene_.cells.first_column = 0; },
      [&] { scene_.cells.last_row = 8; },
      [&] { scene_.cells.out_of_bounds_kind = 7; },
      [&] { scene_.cells.looks[5].theme = 1; },
      [&] { scene_.cells.dots.kind = 4; },
      [&] { grid_.Set(7, 5, 3); },
      [&] { grid_.Set(0, 2, 3); },
      [&] { grid_.Reset(8, 7, kEmptyKind); },
      [&] { scene_.below_cells.push_back({}); },
      [&] { scene_.below_cells[0].x += 1; },
      [&] { scene_.cells.grid = nullptr; },
  };
  for (size_t i = 0; i < changes.size(); ++i) {
    Keep();
    changes[i]();
    EXPECT_EQ(layer_.Classify(scene_), Use::kDrawOnly) << "change " << i;
  }
}

TEST_F(StaticLayerCacheTest, CellsOutOfViewAndSpritesAboveCellsAreIgnored) {
  Keep();
  grid_.Set(3, 1, 3);
  scene_.above_cells.push_back({});
  EXPECT_EQ(layer_.Classify(scene_), Use::kCopy);
}

TEST_F(StaticLayerCacheTest, GeneratedBackgroundsAreNotCached) {
  const GeneratedArt art;
  scene_.background.generated = &art;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(layer_.Classify(scene_), Use::kDrawOnly);
  }
}

}  // namespace
}  // namespace procgen
