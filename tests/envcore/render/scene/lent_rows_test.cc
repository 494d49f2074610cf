#include "envcore/render/scene/lent_rows.h"

#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

constexpr int kSidePx = 6;

class LentRowsTest : public ::testing::Test {
 protected:
  LentRowsTest() {
    TextFrame kept(kSidePx);
    for (int row = 0; row < kSidePx; ++row) {
      for (int x = 0; x < kSidePx; ++x) {
        *kept.frame().At(x, row) = {static_cast<uint8_t>('a' + row), 0, 0, 255};
      }
    }
    layer_.Keep(kept.frame());
  }

  StillLayer layer_;
  LentRows rows_;
  TextFrame frame_{kSidePx};
};

TEST_F(LentRowsTest, RowsThatAreTakenBackHaveTheirPixels) {
  rows_.LendAll(layer_, kSidePx);
  rows_.TakeBack(1, 3, frame_.frame());
  EXPECT_EQ(frame_.Text(), R"(
......
bbbbbb
cccccc
......
......
......
)");
  EXPECT_EQ(rows_.lent(), 0b111001U);
  EXPECT_EQ(rows_.layer(), &layer_);
}

TEST_F(LentRowsTest, WhatWasDrawnOnRowsTakenBackStays) {
  rows_.LendAll(layer_, kSidePx);
  rows_.TakeBack(2, 3, frame_.frame());
  *frame_.frame().At(0, 2) = {'x', 0, 0, 255};
  rows_.TakeBack(-4, 99, frame_.frame());
  EXPECT_EQ(frame_.Text(), R"(
aaaaaa
bbbbbb
xccccc
dddddd
eeeeee
ffffff
)");
}

TEST_F(LentRowsTest, NothingIsLentAnyMoreWhenItIsCleared) {
  rows_.LendAll(layer_, kSidePx);
  rows_.Clear();
  EXPECT_EQ(rows_.lent(), 0U);
  rows_.TakeBack(0, kSidePx, frame_.frame());
  EXPECT_EQ(frame_.Text(), TextFrame(kSidePx).Text());
}

}  // namespace
}  // namespace procgen
