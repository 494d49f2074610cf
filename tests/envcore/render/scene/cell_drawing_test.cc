// Cells are drawn from positions computed once per column and row. Each must equal its image drawn
// alone, for all images, cameras and frame sizes.
#include "envcore/render/scene/cell_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/random/random_stream.h"
#include "envcore/render/art/art_pack.h"
#include "envcore/render/art/nearest_sampling.h"
#include "envcore/world/grid.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/random_png.h"

namespace procgen {
namespace {

constexpr int kGridSize = 12;

struct ImageCase {
  int width;
  int height;
  bool is_opaque;
};
// Of kinds 0, 1, ...
constexpr ImageCase kImages[] = {{128, 128, true},  {17, 17, false}, {64, 40, true},
                                 {128, 128, false}, {5, 4, true},    {4, 4, true}};

GameArt RandomArt(std::vector<ArtFile>* files, std::vector<std::string>* contents) {
  static constexpr ArtSlot kSlots[] = {
      {0, 0, "a", "a.png", 128, 128}, {1, 0, "b", "b.png", 17, 17}, {2, 0, "c", "c.png", 64, 40},
      {3, 0, "d", "d.png", 128, 128}, {4, 0, "e", "e.png", 5, 4},   {5, 0, "f", "f.png", 4, 4}};
  for (const ImageCase& image : kImages) {
    contents->push_back(RandomPng(image.width, image.height, image.is_opaque,
                                  static_cast<int64_t>(contents->size())));
  }
  for (size_t kind = 0; kind < contents->size(); ++kind) {
    files->push_back({std::string(kSlots[kind].upstream_path), (*contents)[kind]});
  }
  return {std::make_shared<ArtPack>(ArtLayout::kUpstream, *files), "test", kSlots, 1, {}};
}

class CellDrawingTest : public testing::Test {
 protected:
  CellDrawingTest() : art_(RandomArt(&files_, &contents_)) {
    scene_.art_style = ArtStyle::kPictures;
    for (size_t kind = 0; kind < scene_.cells.looks.size(); ++kind) {
      scene_.cells.looks[kind].image_kind = static_cast<int16_t>(kind);
    }
  }

  // A random camera and random cells, some of them empty. Two of three times few cells differ from
  // their left or lower neighbor, so that rows or columns have long runs.
  void Shuffle() {
    scene_.camera.cells = random_.Int(4) == 0 ? 16 : 4 + 16 * random_.Unit();
    scene_.camera.center_x = (kGridSize + 4) * random_.Unit() - 2;
    scene_.camera.center_y = (kGridSize + 4) * random_.Unit() - 2;
    grid_.Reset(kGridSize, kGridSize, kEmptyKind);
    const int run = random_.Int(3);
    const int left = run == 1 ? 1 : 0;
    const int below = run == 2 ? 1 : 0;
    for (int x = 0; x < kGridSize; ++x) {
      for (int y = 0; y < kGridSize; ++y) {
        const int kind = random_.Int(static_cast<int>(std::size(kImages)) + 2);
        if (run > 0 && x >= left && y >= below && random_.Int(5) > 0) {
          grid_.Set(x, y, grid_.At(x - left, y - below));
          continue;
        }
        grid_.Set(x, y, kind < static_cast<int>(std::size(kImages)) ? kind : kEmptyKind);
      }
    }
    CellLayer& cells = scene_.cells;
    cells.grid = &grid_;
    const float half = scene_.camera.cells / 2;
    cells.first_column = static_cast<int>(std::floor(scene_.camera.center_x - half)) - 1;
    cells.last_column = static_cast<int>(std::ceil(scene_.camera.center_x + half)) + 1;
    cells.first_row = static_cast<int>(std::floor(scene_.camera.center_y - half)) - 1;
    cells.last_row = static_cast<int>(std::ceil(scene_.camera.center_y + half)) + 1;
    cells.out_of_bounds_kind = random_.Int(2) == 0 ? kOutsideKind : 0;
  }

  int KindAt(int x, int y) const {
    return grid_.Contains(x, y) ? grid_.At(x, y) : scene_.cells.out_of_bounds_kind;
  }

  std::vector<ArtFile> files_;
  std::vector<std::string> contents_;
  GameArt art_;
  Scene scene_;
  Grid grid_;
  RandomStream random_;
  CellDrawing drawing_;
};

TEST_F(CellDrawingTest, EachCellEqualsItsImageDrawnAlone) {
  for (int round = 0; round < 300; ++round) {
    Shuffle();
    const int size_px = round % 3 == 0 ? 16 + random_.Int(120) : 64;
    const bool is_generated = round % 5 == 0;
    scene_.art_style = is_generated ? ArtStyle::kGenerated : ArtStyle::kPictures;
    const Viewport viewport(scene_.camera, size_px);
    std::vector<Rgba> pixels(static_cast<size_t>(size_px * size_px), Rgba{9, 8, 7, 255});
    std::vector<Rgba> expected = pixels;
    const Frame frame = {pixels.data(), size_px};
    drawing_.Begin(scene_, art_, viewport, frame);
    drawing_.Draw();
    const Frame expected_frame = {expected.data(), size_px};
    for (int x = scene_.cells.first_column; x <= scene_.cells.last_column; ++x) {
      for (int y = scene_.cells.first_row; y <= scene_.cells.last_row; ++y) {
        if (const int kind = KindAt(x, y); kind != kEmptyKind && kind != kOutsideKind) {
          const ScreenRect rect = viewport.OfCell(x, y);
          if (is_generated) {
            DrawNearestGenerated(*art_.GeneratedOf(kind, false).picture, rect, 0, 1,
                                 expected_frame);
          } else {
            DrawNearest(*art_.SpriteOf(kind, 0, false).picture, rect, 0, 1, expected_frame);
          }
        }
      }
    }
    ASSERT_TRUE(pixels == expected) << "round " << round << ", size " << size_px;
  }
}

TEST_F(CellDrawingTest, HiddenPixelsAreThoseThatCellsReplace) {
  int hidden_count = 0;
  for (int round = 0; round < 100; ++round) {
    Shuffle();
    const Viewport viewport(scene_.camera, 64);
    std::vector<Rgba> dark(64 * 64, Rgba{0, 0, 0, 255});
    std::vector<Rgba> light(64 * 64, Rgba{255, 255, 255, 255});
    PixelSet hidden;
    for (std::vector<Rgba>* pixels : {&dark, &light}) {
      const Frame frame = {pixels->data(), 64};
      drawing_.Begin(scene_, art_, viewport, frame);
      drawing_.AddHidden(&hidden);
      drawing_.Draw();
    }
    size_t i = 0;
    for (int row = 0; row < 64; ++row) {
      uint64_t seen = 0;
      hidden.ForEachRunOutside(row, 0, 64,
                               [&](int first, int end) { seen |= BitRange(first, end); });
      for (int x = 0; x < 64; ++x, ++i) {
        if ((seen >> x & 1) == 0) {
          ++hidden_count;
          ASSERT_EQ(dark[i], light[i]) << "round " << round << " at " << x << ", " << row;
        }
      }
    }
  }
  EXPECT_GT(hidden_count, 100 * 64 * 64 / 5);
}

}  // namespace
}  // namespace procgen
