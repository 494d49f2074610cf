#include "envcore/render/art/nearest_sampling.h"

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "envcore/render/art/column_copies.h"
#include "envcore/render/art/rotated_image.h"
#include "envcore/render/art/upright_image.h"
#include "envcore/render/raster/rotated_runs.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

constexpr float kQuarterTurn = std::numbers::pi_v<float> / 2;
constexpr float kHalfTurn = std::numbers::pi_v<float>;

MipmappedImage Abcd() { return MipmappedImage(ImageOf({"ab", "cd"}), Levels::kOne); }

std::string Drawn(const MipmappedImage& picture, const ScreenRect& rect, float rotation = 0) {
  TextFrame frame(6);
  DrawNearest(picture, rect, rotation, 1, frame.frame());
  return frame.Text();
}

TEST(NearestSamplingTest, StretchesAnImageIntoTheRectangle) {
  EXPECT_EQ(Drawn(Abcd(), {1, 1, 4, 2}), R"(
......
.aabb.
.ccdd.
......
......
......
)");
}

TEST(NearestSamplingTest, AnImageOfItsOwnSizeIsCopiedToTheNearestPixel) {
  EXPECT_EQ(Drawn(Abcd(), {2.4, 0.6, 2, 2}), R"(
......
..ab..
..cd..
......
......
......
)");
}

TEST(NearestSamplingTest, IsClippedToTheFrame) {
  EXPECT_EQ(Drawn(Abcd(), {-2, 4, 4, 4}), R"(
......
......
......
......
bb....
bb....
)");
  EXPECT_EQ(Drawn(Abcd(), {-1, -1, 2, 2}), R"(
d.....
......
......
......
......
......
)");
}

TEST(NearestSamplingTest, AnImageOfItsOwnSizeIsNotDrawnIfItStartsInsideTheLastPixel) {
  EXPECT_EQ(Drawn(Abcd(), {5.0, 0, 2, 2}).substr(0, 8), "\n.....a\n");
  EXPECT_EQ(Drawn(Abcd(), {5.1, 0, 2, 2}), TextFrame(6).Text());
}

TEST(NearestSamplingTest, EmptyRectanglesAreNotDrawn) {
  const std::string nothing = TextFrame(6).Text();
  EXPECT_EQ(Drawn(Abcd(), {1, 1, 0, 4}), nothing);
  EXPECT_EQ(Drawn(Abcd(), {1, 1, 4, -4}), nothing);
  EXPECT_EQ(Drawn(Abcd(), {1, 1, 0, 4}, 1), nothing);
  EXPECT_EQ(Drawn(Abcd(), {1, 1, 1e-9, 1e-9}), nothing);
}

TEST(NearestSamplingTest, TinyRectanglesOverOnePixelCenterStayInTheImage) {
  EXPECT_THAT(Drawn(Abcd(), {0.49999, 0.49999, 0.00002, 0.00002}), ::testing::SizeIs(43));
}

TEST(NearestSamplingTest, HalfTurnReversesBothAxes) {
  EXPECT_EQ(Drawn(Abcd(), {1, 1, 4, 4}, kHalfTurn), R"(
......
.ddcc.
.ddcc.
.bbaa.
.bbaa.
......
)");
}

TEST(NearestSamplingTest, QuarterTurnIsClockwise) {
  EXPECT_EQ(Drawn(Abcd(), {1, 1, 4, 4}, kQuarterTurn), R"(
......
.ccaa.
.ccaa.
.ddbb.
.ddbb.
......
)");
}

TEST(NearestSamplingTest, LargeQuarterTurnIsClockwiseToo) {
  TextFrame frame(20);
  DrawNearest(Abcd(), {2, 2, 16, 16}, -kQuarterTurn, 1, frame.frame());
  EXPECT_EQ(frame.At(3, 3).red, 'b');
  EXPECT_EQ(frame.At(16, 3).red, 'd');
  EXPECT_EQ(frame.At(3, 16).red, 'a');
  EXPECT_EQ(frame.At(16, 16).red, 'c');
  EXPECT_EQ(frame.At(1, 5).red, 0);
  EXPECT_EQ(frame.At(18, 5).red, 0);
}

TEST(NearestSamplingTest, RotatedImagesCoverAboutTheirArea) {
  for (const double side : {5.3, 31.7}) {
    for (int turn = 0; turn < 17; ++turn) {
      const float rotation = 0.1F + 0.37F * static_cast<float>(turn);
      TextCanvas canvas(64);
      const RotatedRect rotated({30.2 - side / 2, 31.1 - side / 4, side, side / 2}, rotation);
      if (side > 16) {
        EmitLargeRotated(rotated, 64, canvas);
      } else {
        EmitThickLine(rotated.Map(-side / 2, 0), rotated.Map(side / 2, 0), 0.5, 64, canvas);
      }
      const std::string text = canvas.Text();
      const auto pixels = static_cast<double>(std::count(text.begin(), text.end(), '#'));
      EXPECT_NEAR(pixels, side * side / 2, side + 3) << text;
      EXPECT_EQ(text.find('2'), std::string::npos);
    }
  }
}

TEST(NearestSamplingTest, RotatedImagesFarOutsideAreNotDrawn) {
  const std::string nothing = TextFrame(6).Text();
  EXPECT_EQ(Drawn(Abcd(), {-300, 2, 4, 4}, 0.7F), nothing);
  EXPECT_EQ(Drawn(Abcd(), {2, 300, 40, 40}, 0.7F), nothing);
}

TEST(NearestSamplingTest, OpacityFadesEachChannel) {
  TextFrame frame(1);
  Image white(1, 1);
  white.At(0, 0) = {255, 255, 255, 255};
  DrawNearest(MipmappedImage(white, Levels::kOne), {0, 0, 1, 1}, 0, 0.5F, frame.frame());
  EXPECT_EQ(frame.At(0, 0).red, 127);
}

TEST(NearestSamplingTest, GeneratedSpritesAreDrawnUprightAndUpsideDown) {
  TextFrame upright(6);
  DrawNearestGenerated(Abcd(), {1, 1, 4, 4}, 0, 1, upright.frame());
  EXPECT_EQ(upright.Text(), Drawn(Abcd(), {1, 1, 4, 4}));
  TextFrame rotated(6);
  DrawNearestGenerated(Abcd(), {1, 1, 4, 4}, kHalfTurn, 1, rotated.frame());
  EXPECT_EQ(rotated.Text(), Drawn(Abcd(), {1, 1, 4, 4}, kHalfTurn));
}

TEST(NearestSamplingTest, BackdropsReplaceThePixels) {
  TextFrame frame(6);
  DrawNearestBackdrop(Abcd(), {0, 0, 6, 6}, BackdropMotion::kAny, nullptr, frame.frame());
  EXPECT_EQ(frame.Text(), R"(
aaabbb
aaabbb
aaabbb
cccddd
cccddd
cccddd
)");
}

TEST(NearestSamplingTest, ScaledBackdropsCoverTheSamePixelsFromOneImage) {
  const MipmappedImage picture(ImageOf({"aabb", "aabb", "ccdd", "ccdd"}), Levels::kAll);
  TextFrame frame(6);
  // From 1.25, a length of 3.5 covers four columns; from 0.75, three rows.
  DrawNearestBackdrop(picture, {1.25, 0.75, 3.5, 3.5}, BackdropMotion::kAny, nullptr,
                      frame.frame());
  EXPECT_EQ(frame.Text(), R"(
......
.aabb.
.aabb.
.ccdd.
......
......
)");
  DrawNearestBackdrop(picture, {-1, 4, 3.5, 3.5}, BackdropMotion::kAny, nullptr, frame.frame());
  EXPECT_EQ(frame.Text(), R"(
......
.aabb.
.aabb.
.ccdd.
abb...
abb...
)");
  EXPECT_NE(picture.KeptAt({.width = 4, .height = 4}), nullptr);
}

// A server draws many sizes; what it kept before changes no pixel.
TEST(NearestSamplingTest, BackdropsAreTheSameWithAFullCache) {
  std::mt19937 random(7);
  Image image(300, 200);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image.At(x, y) = {static_cast<uint8_t>(random()), static_cast<uint8_t>(random()), 9, 255};
    }
  }
  const MipmappedImage fresh(image, Levels::kAll);
  const MipmappedImage full(image, Levels::kAll);
  for (int width = 1000; full.KeptAt({.width = width, .height = 1}) != nullptr; ++width) {
  }
  for (const ScreenRect& rect : std::vector<ScreenRect>{{-100.5, -60.25, 250.5, 190.75},
                                                        {3.4, 5.2, 20, 30},
                                                        {-7, -7, 640, 640},
                                                        {0, 0, 64, 64},
                                                        {60.6, 60.6, 100, 100}}) {
    BackdropPixels hidden;
    hidden.hidden.Add(40, BitRange(20, 50));
    BackdropPixels hidden_too = hidden;
    std::vector<Rgba> pixels(64 * 64);
    std::vector<Rgba> expected(64 * 64);
    DrawNearestBackdrop(full, rect, BackdropMotion::kAny, &hidden, {pixels.data(), 64});
    DrawNearestBackdrop(fresh, rect, BackdropMotion::kAny, &hidden_too, {expected.data(), 64});
    EXPECT_EQ(pixels, expected) << rect.x << ", " << rect.y;
  }
}

TEST(NearestSamplingTest, BackdropsMarkPixelsDone) {
  const MipmappedImage exact = Abcd();
  const MipmappedImage scales(ImageOf({"ab", "cd"}), Levels::kAll);
  for (const MipmappedImage* picture : {&exact, &scales}) {
    BackdropPixels pixels;
    pixels.hidden.Add(1, BitRange(2, 4));
    TextFrame frame(6);
    DrawNearestBackdrop(*picture, {0, 0, 4, 4}, BackdropMotion::kAny, &pixels, frame.frame());
    EXPECT_EQ(frame.Text(), R"(
aabb..
aa....
ccdd..
ccdd..
......
......
)");
    int left = 0;
    for (int row = 0; row < 6; ++row) {
      pixels.done.ForEachRunOutside(row, 0, 6, [&](int first, int end) { left += end - first; });
    }
    EXPECT_EQ(left, 6 * 6 - 4 * 4);
  }
}

// Each rectangle is drawn often enough that columns are copied.
void ExpectTheSameWithCopies(const MipmappedImage& picture, const std::vector<ScreenRect>& rects,
                             BackdropMotion motion) {
  std::mt19937 random(3);
  std::vector<Rgba> pixels(64 * 64);
  for (int round = 0; round <= ColumnCopies::kRequestsMin; ++round) {
    for (const ScreenRect& rect : rects) {
      BackdropPixels hidden;
      for (int row = 0; row < 64; ++row) {
        const int first = static_cast<int>(random() % 80);
        hidden.hidden.Add(row, BitRange(first, first + 20));
      }
      BackdropPixels hidden_too = hidden;
      std::fill(pixels.begin(), pixels.end(), Rgba());
      DrawNearestBackdrop(picture, rect, motion, &hidden, {pixels.data(), 64});
      std::vector<Rgba> expected(64 * 64);
      DrawBackdrop(picture.level(0), rect, motion, nullptr, &hidden_too, {expected.data(), 64});
      ASSERT_EQ(pixels, expected) << rect.x << ", " << rect.y << ", round " << round;
    }
  }
}

TEST(NearestSamplingTest, CopiesOfColumnsChangeNoPixelOfABackdrop) {
  std::mt19937 random(5);
  Image image(400, 300);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image.At(x, y) = {static_cast<uint8_t>(random()), static_cast<uint8_t>(random()), 9, 255};
    }
  }
  const MipmappedImage picture(std::move(image), Levels::kOne);
  std::uniform_real_distribution<double> place(-150, 60);
  std::uniform_real_distribution<double> size(20, 190);
  std::vector<ScreenRect> any(40);
  for (ScreenRect& rect : any) {
    rect = {place(random), place(random), size(random), size(random)};
  }
  ExpectTheSameWithCopies(picture, any, BackdropMotion::kAny);
  // A third of a pixel, too, as rounding errors are largest there.
  for (const double distance : {0.8, 1.0 / 3}) {
    std::vector<ScreenRect> sideways(200);
    for (size_t i = 0; i < sideways.size(); ++i) {
      sideways[i] = {60 - static_cast<double>(i) * distance, -64, 192.0 * 23 / 24, 192};
    }
    ExpectTheSameWithCopies(MipmappedImage(picture.level(0), Levels::kOne), sideways,
                            BackdropMotion::kSideways);
  }
}

}  // namespace
}  // namespace procgen
