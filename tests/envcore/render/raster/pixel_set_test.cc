#include "envcore/render/raster/pixel_set.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

std::string Outside(const PixelSet& set, int row, int first, int end) {
  std::string runs;
  set.ForEachRunOutside(row, first, end,
                        [&](int from, int to) { absl::StrAppend(&runs, from, "-", to, " "); });
  return runs;
}

TEST(PixelSetTest, TheWholeRunIsOutsideAnEmptySet) {
  EXPECT_EQ(Outside({}, 0, -3, 99), "0-64 ");
  EXPECT_EQ(Outside({}, 63, 63, 64), "63-64 ");
  EXPECT_EQ(Outside({}, 5, 7, 7), "");
}

TEST(PixelSetTest, ColumnsInTheSetSplitTheRun) {
  PixelSet set;
  set.Add(2, BitRange(0, 4));
  set.Add(2, BitRange(10, 20));
  set.Add(2, BitRange(63, 64));
  EXPECT_EQ(Outside(set, 2, 0, 64), "4-10 20-63 ");
  EXPECT_EQ(Outside(set, 2, 12, 18), "");
  EXPECT_EQ(Outside(set, 1, 0, 64), "0-64 ");
}

TEST(BackdropPixelsTest, HiddenPixelsAreDoneWithoutBeingDrawn) {
  BackdropPixels pixels;
  pixels.hidden.Add(1, BitRange(3, 5));
  std::string runs;
  ForEachRunToDraw({2, 0, 8, 2}, &pixels, [&](int row, int first, int end) {
    absl::StrAppend(&runs, row, ":", first, "-", end, " ");
  });
  EXPECT_EQ(runs, "0:2-8 1:2-3 1:5-8 ");
  EXPECT_EQ(Outside(pixels.done, 1, 0, 10), "0-2 8-10 ");
  EXPECT_EQ(Outside(pixels.done, 2, 0, 10), "0-10 ");
}

TEST(BackdropPixelsTest, AnEmptyBoxHasNoRuns) {
  const auto fail = [](int row, int first, int end) { FAIL() << row << first << end; };
  BackdropPixels pixels;
  ForEachRunToDraw({5, 0, 5, 2}, &pixels, fail);
  ForEachRunToDraw({5, 0, 4, 2}, nullptr, fail);
  ForEachRunToDraw({0, 3, 9, 3}, nullptr, fail);
}

}  // namespace
}  // namespace procgen
