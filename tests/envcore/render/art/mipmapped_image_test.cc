#include "envcore/render/art/mipmapped_image.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

TEST(MipmappedImageTest, LevelsGoDownToOnePixel) {
  const MipmappedImage picture(Image(5, 2), Levels::kAll);
  ASSERT_EQ(picture.level_count(), 4);
  EXPECT_EQ(picture.level(1).width(), 3);
  EXPECT_EQ(picture.level(1).height(), 1);
  EXPECT_EQ(picture.level(3).width(), 1);
}

TEST(MipmappedImageTest, OneLevelServesAllSizes) {
  const MipmappedImage picture(Image(64, 64), Levels::kOne);
  EXPECT_EQ(picture.LevelFor(3, 3).width(), 64);
}

TEST(MipmappedImageTest, LevelIsTheSmallestThatIsLargeEnough) {
  const MipmappedImage picture(Image(64, 32), Levels::kAll);
  EXPECT_EQ(picture.LevelFor(16, 8).width(), 16);
  EXPECT_EQ(picture.LevelFor(16.1, 8).width(), 32);
  EXPECT_EQ(picture.LevelFor(2, 30).width(), 64);
  EXPECT_EQ(picture.LevelFor(1000, 1000).width(), 64);
}

TEST(MipmappedImageTest, ReducedPixelsAreMeansOfPremultipliedOnes) {
  Image image(2, 1);
  image.At(0, 0) = {200, 100, 0, 200};
  const MipmappedImage picture(image, Levels::kAll);
  EXPECT_EQ(picture.level(1).At(0, 0), (Rgba{100, 50, 0, 100}));
}

TEST(MipmappedImageTest, ReportsWhetherItIsOpaque) {
  EXPECT_TRUE(MipmappedImage(ImageOf({"ab", "cd"}), Levels::kOne).opaque());
  EXPECT_FALSE(MipmappedImage(ImageOf({"ab", "c."}), Levels::kOne).opaque());
}

TEST(MipmappedImageTest, MirroringReversesTheColumns) {
  const MipmappedImage mirrored = MipmappedImage(ImageOf({"abc"}), Levels::kAll).Mirrored();
  EXPECT_EQ(mirrored.level(0).At(0, 0).red, 'c');
  EXPECT_EQ(mirrored.level(0).At(2, 0).red, 'a');
}

}  // namespace
}  // namespace procgen
