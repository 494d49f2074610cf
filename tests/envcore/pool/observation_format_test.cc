#include "envcore/pool/observation_format.h"

#include <string>

#include "envcore/pool/pool.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

ObservationFormat FormatOf(int32_t size_px, Color color, Layout layout, int32_t frame_stack) {
  ObservationFormat format;
  format.frame = {.size_px = size_px, .color = color, .layout = layout};
  format.frame_stack = frame_stack;
  return format;
}

TEST(ObservationFormatTest, TheDefaultIsTheUpstreamObservation) {
  EXPECT_THAT(ObservationFormat().Shape(), ElementsAre(64, 64, 3));
  EXPECT_EQ(ObservationFormat().bytes(), kObservationBytes);
  EXPECT_EQ(ObservationFormat().frame.size_px, kObservationSizePx);
}

TEST(ObservationFormatTest, ShapesFollowLayoutColorAndStack) {
  EXPECT_THAT(FormatOf(84, Color::kRgb, Layout::kHwc, 1).Shape(), ElementsAre(84, 84, 3));
  EXPECT_THAT(FormatOf(84, Color::kRgb, Layout::kChw, 1).Shape(), ElementsAre(3, 84, 84));
  EXPECT_THAT(FormatOf(84, Color::kGrayscale, Layout::kHwc, 1).Shape(), ElementsAre(84, 84, 1));
  EXPECT_THAT(FormatOf(84, Color::kGrayscale, Layout::kChw, 4).Shape(), ElementsAre(4, 1, 84, 84));
  EXPECT_THAT(FormatOf(16, Color::kRgb, Layout::kHwc, 2).Shape(), ElementsAre(2, 16, 16, 3));
}

TEST(ObservationFormatTest, BytesAreTheProductOfTheShape) {
  EXPECT_EQ(FormatOf(84, Color::kGrayscale, Layout::kHwc, 4).bytes(), 4U * 84 * 84);
  EXPECT_EQ(FormatOf(512, Color::kRgb, Layout::kChw, 16).bytes(), 16U * 512 * 512 * 3);
}

TEST(ObservationFormatTest, ValuesOutOfRangeAreRejected) {
  const auto message = [](const ObservationFormat& format) {
    const absl::Status status = CheckObservationFormat(format);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  const auto rgb = Color::kRgb;
  const auto hwc = Layout::kHwc;
  EXPECT_EQ(message(FormatOf(15, rgb, hwc, 1)),
            "observation_format.frame.size_px is 15, must be in [16, 512]");
  EXPECT_EQ(message(FormatOf(513, rgb, hwc, 1)),
            "observation_format.frame.size_px is 513, must be in [16, 512]");
  EXPECT_EQ(message(FormatOf(64, rgb, hwc, 0)),
            "observation_format.frame_stack is 0, must be in [1, 16]");
  EXPECT_EQ(message(FormatOf(64, rgb, hwc, 17)),
            "observation_format.frame_stack is 17, must be in [1, 16]");
  EXPECT_EQ(message(FormatOf(64, static_cast<Color>(2), hwc, 1)),
            "observation_format.frame.color is 2, must be in [0, 1]");
  EXPECT_EQ(message(FormatOf(64, rgb, static_cast<Layout>(-1), 1)),
            "observation_format.frame.layout is -1, must be in [0, 1]");
}

}  // namespace
}  // namespace procgen
