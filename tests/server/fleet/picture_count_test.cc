#include "server/fleet/picture_count.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(PictureCountTest, SinglePicturesNeedNone) {
  EXPECT_TRUE(PictureCount({0, 4}, 1).IsComplete());
}

TEST(PictureCountTest, EachEnvironmentOfTheRangeAddsAllButOne) {
  PictureCount pictures({2, 2}, 3);
  EXPECT_FALSE(pictures.IsComplete());
  pictures.AddStep({0, 8});
  pictures.AddStep({0, 3});  // the first of the range alone
  EXPECT_FALSE(pictures.IsComplete());
  pictures.AddStep({4, 4});  // none of it
  EXPECT_FALSE(pictures.IsComplete());
  pictures.AddStep({3, 1});
  EXPECT_TRUE(pictures.IsComplete());
  pictures.Clear();
  EXPECT_FALSE(pictures.IsComplete());
}

}  // namespace
}  // namespace procgen
