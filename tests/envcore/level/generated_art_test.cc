#include "envcore/level/generated_art.h"

#include <cstdint>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

// The number of draws of a shape with one or two stripes, with or without their own colors.
uint64_t ShapeDraws(RandomStream random) {
  const int32_t k = random.Int(10);
  const int32_t stripes = k * k / 50 + 1;
  random.Coin();
  random.Coin();
  return 10 + (random.Coin() ? 6U * static_cast<uint64_t>(stripes) : 0U);
}

void Skip(RandomStream& random, uint64_t draws) {
  for (uint64_t i = 0; i < draws; ++i) {
    random.Raw();
  }
}

TEST(GeneratedArtTest, FigureTakesTheDrawsOfItsBarsAndBlotches) {
  for (int64_t seed = 0; seed < 50; ++seed) {
    RandomStream random(seed);
    GenerateFigure(random);
    RandomStream expected(seed);
    Skip(expected, 8);  // palette and orientation
    const int32_t first_bars = expected.Int(3) / 2 + 1;
    const int32_t second_bars = expected.Int(3) / 2 + 1;
    for (int32_t i = 0; i < first_bars + second_bars; ++i) {
      Skip(expected, 3);
      Skip(expected, ShapeDraws(expected));
    }
    const int32_t blotches = expected.Int(1, 5);
    for (int32_t i = 0; i < blotches; ++i) {
      Skip(expected, 4);
      Skip(expected, ShapeDraws(expected));
    }
    EXPECT_EQ(random.draws(), expected.draws()) << seed;
  }
}

TEST(GeneratedArtTest, BlockSpriteTakesTheDrawsOfItsBlotches) {
  for (int64_t seed = 0; seed < 50; ++seed) {
    RandomStream random(seed);
    GenerateBlock(random);
    RandomStream expected(seed);
    Skip(expected, 11);  // palette, ground, coarseness
    const int32_t blotches = expected.Int(5, 10);
    Skip(expected, 1);  // drawn even without recursion
    for (int32_t i = 0; i < blotches; ++i) {
      Skip(expected, 4);
      Skip(expected, ShapeDraws(expected));
    }
    EXPECT_EQ(random.draws(), expected.draws()) << seed;
  }
}

TEST(GeneratedArtTest, BlocksFillTheirCanvasFirstAndBlendOverItLast) {
  RandomStream random(3);
  for (const GeneratedArt& art : {GenerateBlock(random), GenerateBackground(random)}) {
    for (const PaintStep& step : {art.steps.front(), art.steps.back()}) {
      EXPECT_EQ(step.shape, PaintStep::Shape::kRectangle);
      EXPECT_EQ(step.x, 0);
      EXPECT_EQ(step.y, 0);
      EXPECT_EQ(step.width, art.size_px);
      EXPECT_EQ(step.height, art.size_px);
    }
    EXPECT_EQ(art.steps.front().alpha, 255);
    EXPECT_EQ(art.steps.back().alpha, 200);
    EXPECT_EQ(art.steps.back().fill, art.steps.front().fill);
    EXPECT_FALSE(art.transparent);
  }
}

TEST(GeneratedArtTest, BackgroundsContainNestedBlocks) {
  RandomStream random(3);
  const GeneratedArt art = GenerateBackground(random);
  int veils = 0;
  for (const PaintStep& step : art.steps) {
    veils += step.alpha == 200 ? 1 : 0;
  }
  EXPECT_EQ(art.size_px, 500);
  EXPECT_GT(veils, 1);
  EXPECT_LE(veils, 100);
}

TEST(GeneratedArtTest, PartsAreInsideTheCanvas) {
  for (int64_t seed = 0; seed < 20; ++seed) {
    RandomStream random(seed);
    const GeneratedArt art = GenerateFigure(random);
    EXPECT_TRUE(art.transparent);
    for (const PaintStep& step : art.steps) {
      EXPECT_GE(step.x, 0);
      EXPECT_GE(step.y, 0);
      EXPECT_LE(step.x + step.width, 64.001);
      EXPECT_LE(step.y + step.height, 64.001);
      EXPECT_EQ(step.alpha, 255);
    }
  }
}

}  // namespace
}  // namespace procgen
