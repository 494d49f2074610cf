#include "envcore/render/hidden_pixels.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

std::string Shown(const HiddenPixels& hidden, int row, int first, int end) {
  std::string runs;
  hidden.ForEachShown(row, first, end,
                      [&](int from, int to) { absl::StrAppend(&runs, from, "-", to, " "); });
  return runs;
}

TEST(HiddenPixelsTest, ColumnsAreCutToTheFrame) {
  EXPECT_EQ(HiddenPixels::Columns(-5, 3), 0b111U);
  EXPECT_EQ(HiddenPixels::Columns(62, 99), uint64_t{3} << 62);
  EXPECT_EQ(HiddenPixels::Columns(-9, 99), ~uint64_t{0});
  EXPECT_EQ(HiddenPixels::Columns(-9, 0), 0U);
  EXPECT_EQ(HiddenPixels::Columns(64, 70), 0U);
  EXPECT_EQ(HiddenPixels::Columns(5, 4), 0U);
}

TEST(HiddenPixelsTest, WithoutAnyHiddenTheWholeRunIsShown) {
  EXPECT_EQ(Shown({}, 0, -3, 99), "0-64 ");
  EXPECT_EQ(Shown({}, 63, 63, 64), "63-64 ");
  EXPECT_EQ(Shown({}, 5, 7, 7), "");
}

TEST(HiddenPixelsTest, HiddenColumnsSplitTheRun) {
  HiddenPixels hidden;
  hidden.Add(2, HiddenPixels::Columns(0, 4));
  hidden.Add(2, HiddenPixels::Columns(10, 20));
  hidden.Add(2, HiddenPixels::Columns(63, 64));
  EXPECT_EQ(Shown(hidden, 2, 0, 64), "4-10 20-63 ");
  EXPECT_EQ(Shown(hidden, 2, 12, 18), "");
  EXPECT_EQ(Shown(hidden, 1, 0, 64), "0-64 ");
}

}  // namespace
}  // namespace procgen
