// Observations of other colors, layouts and sizes. The measure is a pool with the same seeds whose
// frames are red, green and blue: gray frames and planes are made from those by their definition.

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "envcore/pool/pool.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"
#include "tests/envcore/pool/small_pool.h"

namespace procgen {
namespace {

using Pixels = std::vector<uint8_t>;

// Converts `rgb`, uint8 [n, 3], to another format, by the definition of the format.
Pixels Converted(const Pixels& rgb, Color color, Layout layout) {
  Pixels converted;
  const size_t count = rgb.size() / 3;
  for (size_t i = 0; color == Color::kGrayscale && i < count; ++i) {
    const int luma = 77 * rgb[3 * i] + 150 * rgb[3 * i + 1] + 29 * rgb[3 * i + 2];
    converted.push_back(static_cast<uint8_t>((luma + 128) / 256));
  }
  for (size_t channel = 0; color == Color::kRgb && channel < 3; ++channel) {
    for (size_t i = 0; layout == Layout::kChw && i < count; ++i) {
      converted.push_back(rgb[3 * i + channel]);
    }
  }
  return converted.empty() ? rgb : converted;
}

class PoolFormatTest
    : public testing::TestWithParam<std::tuple<std::string, int32_t, Color, Layout>> {};

TEST_P(PoolFormatTest, FramesOfEveryFormatEqualConvertedRgbFrames) {
  const auto& [game, size_px, color, layout] = GetParam();
  ObservationFormat format;
  format.frame.size_px = size_px;
  const auto measure = FormattedPool(game, format);
  const size_t measure_bytes = format.bytes();
  format.frame.color = color;
  format.frame.layout = layout;
  const auto pool = FormattedPool(game, format);
  ASSERT_EQ(pool->observation_bytes(), format.bytes());
  for (int step = 0; step < 12; ++step) {
    std::vector<int32_t> actions = AllTake(step % kActionCount);
    actions[1] = step == 6 ? kEndEpisodeAction : actions[1];
    const BatchBuffers expected = Stepped(*measure, actions);
    const BatchBuffers answered = Stepped(*pool, actions);
    ASSERT_EQ(answered.level_seeds, expected.level_seeds);
    for (size_t i = 0; i < kEnvCount; ++i) {
      ASSERT_EQ(RowOf(answered.observations, format.bytes(), i),
                Converted(RowOf(expected.observations, measure_bytes, i), color, layout));
    }
    ASSERT_EQ(RowOf(answered.final_observations, format.bytes(), 1),
              Converted(RowOf(expected.final_observations, measure_bytes, 1), color, layout));
  }
}

std::string FormatName(
    const testing::TestParamInfo<std::tuple<std::string, int32_t, Color, Layout>>& info) {
  const auto& [game, size_px, color, layout] = info.param;
  return game + std::to_string(size_px) + (color == Color::kRgb ? "Rgb" : "Grayscale") +
         (layout == Layout::kHwc ? "Hwc" : "Chw");
}

INSTANTIATE_TEST_SUITE_P(Formats, PoolFormatTest,
                         testing::Combine(testing::Values("maze", "starpilot"),
                                          testing::Values(64, 84),
                                          testing::Values(Color::kRgb, Color::kGrayscale),
                                          testing::Values(Layout::kHwc, Layout::kChw)),
                         FormatName);

// Means of blocks of `block` x `block` pixels of a square gray image.
std::vector<double> BlockMeans(const Pixels& grey, int size_px, int block) {
  const int blocks = size_px / block;
  std::vector<double> means(static_cast<size_t>(blocks) * static_cast<size_t>(blocks));
  for (int y = 0; y < size_px; ++y) {
    for (int x = 0; x < size_px; ++x) {
      const int cell = y / block * blocks + x / block;
      const int pixel = y * size_px + x;
      means[static_cast<size_t>(cell)] +=
          grey[static_cast<size_t>(pixel)] / static_cast<double>(block * block);
    }
  }
  return means;
}

// Flat colors, so that only positions can differ.
TEST(PoolSizeTest, ObjectsHaveTheSamePositionsAtAllSizes) {
  for (const GameSpec& game : GameCatalog()) {
    const auto view = [&](int32_t size_px) {
      PoolOptions options = OptionsOf({std::string(game.name)}, 1);
      options.environment.rand_seed = 5;
      options.environment.use_monochrome_assets = true;
      options.environment.use_backgrounds = false;
      options.observation_format.frame = {.size_px = size_px, .color = Color::kGrayscale};
      const auto pool = MadePool(options);
      for (int step = 0; step < 20; ++step) {
        Stepped(*pool, {7});
      }
      return Observed(*pool).observations;
    };
    const std::vector<double> small = BlockMeans(view(64), 64, 8);
    const std::vector<double> large = BlockMeans(view(512), 512, 64);
    double difference = 0;
    double brightness = 0;
    for (size_t i = 0; i < small.size(); ++i) {
      difference += std::abs(small[i] - large[i]) / static_cast<double>(small.size());
      brightness += large[i] / static_cast<double>(small.size());
    }
    EXPECT_GT(brightness, 0.5) << game.name;
    EXPECT_LT(difference, 0.2 * brightness) << game.name << ", of brightness " << brightness;
  }
}

TEST(PoolSizeTest, LargeFramesAreDrawnAndNotRescaled) {
  ObservationFormat format;
  format.frame.size_px = 512;
  const auto pool = FormattedPool("coinrun", format);
  const Pixels frame = RowOf(Observed(*pool).observations, format.bytes(), 0);
  int alike = 0;
  for (size_t y = 0; y < 512; y += 8) {
    for (size_t x = 0; x < 512; x += 8) {
      bool same = true;
      for (size_t i = 0; i < 64; ++i) {
        const size_t pixel = ((y + i / 8) * 512 + x + i % 8) * 3;
        same = same && frame[pixel] == frame[(y * 512 + x) * 3];
      }
      alike += same ? 1 : 0;
    }
  }
  EXPECT_LT(alike, 64 * 64 / 2) << "blocks of 8 x 8 pixels of one color";
}

TEST(PoolFormatErrorTest, AFormatOutOfRangeIsRejected) {
  PoolOptions options = OptionsOf({"maze"});
  options.observation_format.frame.size_px = 15;
  const absl::Status status = Pool::Create(options, std::make_shared<WorkerPool>(0)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), "observation_format.frame.size_px is 15, must be in [16, 512]");
}

}  // namespace
}  // namespace procgen
