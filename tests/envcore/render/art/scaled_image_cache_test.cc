#include "envcore/render/art/scaled_image_cache.h"

#include <cstdint>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

Image Checks(int side) {
  Image image(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      image.At(x, y) = (x + y) % 2 == 0 ? Rgba{200, 100, 0, 200} : Rgba{};
    }
  }
  return image;
}

TEST(ScaledTest, TheSameSizeGivesTheSameImage) {
  const Image source = ImageOf({"abc", "de.", "ghi"});
  const Image same = Scaled(source, {.width = 3, .height = 3});
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      EXPECT_EQ(same.At(x, y), source.At(x, y)) << x << " " << y;
    }
  }
}

TEST(ScaledTest, PixelsAreMeansOfTheAreaTheyCover) {
  const Image half = Scaled(Checks(4), {.width = 2, .height = 2});
  EXPECT_EQ(half.At(1, 1), (Rgba{100, 50, 0, 100}));
  // Two pixels from three: the second also gets half of the second source pixel.
  const Image two = Scaled(ImageOf({"a.a"}), {.width = 2, .height = 1});
  EXPECT_EQ(two.At(0, 0), (Rgba{65, 0, 0, 170}));
  EXPECT_EQ(two.At(1, 0), two.At(0, 0));
}

TEST(ScaledTest, LargerImagesRepeatPixels) {
  const Image wide = Scaled(ImageOf({"ab"}), {.width = 4, .height = 2});
  EXPECT_EQ(wide.At(1, 1).red, 'a');
  EXPECT_EQ(wide.At(2, 0).red, 'b');
}

TEST(ScaledTest, NoColorIsAboveItsAlpha) {
  for (int angle = 0; angle < kAngleCount; ++angle) {
    const Image image = Scaled(Checks(7), {.width = 5, .height = 3, .angle = angle});
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        EXPECT_LE(image.At(x, y).red, image.At(x, y).alpha);
      }
    }
  }
}

TEST(ScaledTest, AQuarterTurnIsClockwise) {
  const Image rotated =
      Scaled(ImageOf({"ab"}), {.width = 2, .height = 1, .angle = kAngleCount / 4});
  ASSERT_EQ(rotated.width(), 1);
  ASSERT_EQ(rotated.height(), 2);
  EXPECT_EQ(rotated.At(0, 0).red, 'a');
  EXPECT_EQ(rotated.At(0, 1).red, 'b');
}

TEST(ScaledTest, ARotatedImageIsAsLargeAsItsCorners) {
  const Image rotated = Scaled(Checks(8), {.width = 10, .height = 10, .angle = kAngleCount / 8});
  EXPECT_EQ(rotated.width(), 15);
  EXPECT_EQ(rotated.height(), 15);
  EXPECT_EQ(rotated.At(0, 0).alpha, 0);
}

TEST(HardenedTest, APixelCoveredByAThirdIsOpaqueAndKeepsItsColor) {
  Image image(4, 1);
  image.At(0, 0) = {200, 100, 0, 255};
  image.At(1, 0) = {67, 33, 0, 85};
  image.At(2, 0) = {66, 33, 0, 84};
  Harden(&image);
  EXPECT_EQ(image.At(0, 0), (Rgba{200, 100, 0, 255}));
  EXPECT_EQ(image.At(1, 0), (Rgba{201, 99, 0, 255}));
  EXPECT_EQ(image.At(2, 0), Rgba());
  EXPECT_EQ(image.At(3, 0), Rgba());
}

TEST(HardenedTest, ATranslucentImageStaysTranslucent) {
  Image image(2, 1);
  image.At(0, 0) = {60, 0, 0, 120};
  image.At(1, 0) = {30, 0, 0, 60};
  Harden(&image);
  EXPECT_EQ(image.At(0, 0), (Rgba{60, 0, 0, 120}));
  EXPECT_EQ(image.At(1, 0), image.At(0, 0));
}

TEST(ScaledImageCacheTest, CopiesHaveHardEdges) {
  const ScaledImageCache pictures;
  const auto made = pictures.Make(ImageOf({"aa.", "aa.", "..."}), {.width = 2, .height = 2});
  EXPECT_EQ(made->image.At(0, 0), (Rgba{'a', 0, 0, 255}));
  EXPECT_EQ(made->image.At(1, 0).alpha, 255) << "covered by a third";
  EXPECT_EQ(made->image.At(1, 1), Rgba());
}

TEST(ScaledImageCacheTest, EachSizeIsMadeOnce) {
  const Image source = ImageOf({"ab", "cd"});
  const ScaledImageCache pictures;
  const ScaledSize size = {.width = 5, .height = 4};
  EXPECT_EQ(pictures.Find(size), nullptr);
  const auto made = pictures.Make(source, size);
  EXPECT_TRUE(made->opaque);
  EXPECT_EQ(made->image.width(), 5);
  EXPECT_EQ(pictures.Find(size), made.get());
  EXPECT_EQ(pictures.Make(source, size), made);
  EXPECT_EQ(pictures.Find({.width = 4, .height = 5}), nullptr);
  EXPECT_EQ(pictures.Find({.width = 5, .height = 4, .angle = 1}), nullptr);
}

TEST(ScaledImageCacheTest, KeptBytesAreBounded) {
  const Image source = Checks(9);
  const ScaledImageCache pictures;
  constexpr int kSide = 512;
  int64_t kept_bytes = 0;
  for (int width = 1; width <= kSide; ++width) {
    const ScaledSize size = {.width = width, .height = kSide};
    const auto made = pictures.Make(source, size);
    EXPECT_EQ(made->image.width(), width) << "kept or not";
    if (pictures.Find(size) != nullptr) {
      kept_bytes += int64_t{4} * width * kSide;
    }
  }
  EXPECT_FALSE(pictures.HasRoomFor({.width = kSide, .height = kSide}));
  EXPECT_TRUE(ScaledImageCache().HasRoomFor({.width = kSide, .height = kSide}));
  EXPECT_GT(kept_bytes, ScaledImageCache::kKeptBytesMax / 2);
  EXPECT_LE(kept_bytes, ScaledImageCache::kKeptBytesMax);
}

TEST(ScaledImageCacheTest, ConcurrentRequestsGetTheSameImage) {
  constexpr int kThreadCount = 4;
  constexpr int kSide = 24;
  const Image source = Checks(9);
  const ScaledImageCache pictures;
  std::vector<std::vector<const ScaledImage*>> got(kThreadCount);
  std::vector<std::thread> threads;
  threads.reserve(kThreadCount);
  for (std::vector<const ScaledImage*>& mine : got) {
    threads.emplace_back([&] {
      for (int width = 1; width <= kSide; ++width) {
        for (int height = 1; height <= kSide; ++height) {
          const ScaledSize size = {.width = width, .height = height};
          const ScaledImage* found = pictures.Find(size);
          mine.push_back(found != nullptr ? found : pictures.Make(source, size).get());
        }
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const std::vector<const ScaledImage*>& mine : got) {
    EXPECT_EQ(mine, got[0]);
  }
}

}  // namespace
}  // namespace procgen
