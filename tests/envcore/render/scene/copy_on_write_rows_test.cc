#include "envcore/render/scene/copy_on_write_rows.h"

#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

constexpr int kSizePx = 6;

class CopyOnWriteRowsTest : public ::testing::Test {
 protected:
  CopyOnWriteRowsTest() {
    TextFrame kept(kSizePx);
    for (int row = 0; row < kSizePx; ++row) {
      for (int x = 0; x < kSizePx; ++x) {
        *kept.frame().At(x, row) = {static_cast<uint8_t>('a' + row), 0, 0, 255};
      }
    }
    layer_.Keep(kept.frame());
  }

  StaticLayerCache layer_;
  CopyOnWriteRows rows_;
  TextFrame frame_{kSizePx};
};

TEST_F(CopyOnWriteRowsTest, MaterializedRowsHaveTheirPixels) {
  rows_.ShareAll(layer_, kSizePx);
  rows_.Materialize(1, 3, frame_.frame());
  EXPECT_EQ(frame_.Text(), R"(
......
bbbbbb
cccccc
......
......
......
)");
  EXPECT_EQ(rows_.shared(), 0b111001U);
  EXPECT_EQ(rows_.layer(), &layer_);
}

TEST_F(CopyOnWriteRowsTest, DrawingsOnMaterializedRowsPersist) {
  rows_.ShareAll(layer_, kSizePx);
  rows_.Materialize(2, 3, frame_.frame());
  *frame_.frame().At(0, 2) = {'x', 0, 0, 255};
  rows_.Materialize(-4, 99, frame_.frame());
  EXPECT_EQ(frame_.Text(), R"(
aaaaaa
bbbbbb
xccccc
dddddd
eeeeee
ffffff
)");
}

TEST_F(CopyOnWriteRowsTest, NoRowIsSharedAfterClear) {
  rows_.ShareAll(layer_, kSizePx);
  rows_.Clear();
  EXPECT_EQ(rows_.shared(), 0U);
  rows_.Materialize(0, kSizePx, frame_.frame());
  EXPECT_EQ(frame_.Text(), TextFrame(kSizePx).Text());
}

}  // namespace
}  // namespace procgen
