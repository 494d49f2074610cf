#include "server/session/backend/observation_coding.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(ObservationCodingTest, RawObservationsAreSentUnchanged) {
  const ObservationCoding coding{ObservationFormat()};
  EXPECT_EQ(coding.drawn_bytes(), kObservationBytes);
  EXPECT_EQ(coding.sent_bytes_max(), kObservationBytes);
  EXPECT_EQ(coding.MakeEncoder(4), nullptr);
}

TEST(ObservationCodingTest, EncodedSizeBoundIsOneAndAHalfTimesRaw) {
  for (const Layout layout : {Layout::kHwc, Layout::kChw}) {
    for (const Color color : {Color::kRgb, Color::kGrayscale}) {
      for (int32_t size_px = 16; size_px <= 512; ++size_px) {
        const ObservationFormat format = {.frame = {size_px, color, layout},
                                          .frame_stack = 1 + size_px % 16};
        const ObservationCoding coding(format, Encoding::kDeltaZstd);
        ASSERT_EQ(coding.drawn_bytes(), static_cast<int64_t>(format.bytes()));
        ASSERT_GT(coding.sent_bytes_max(), coding.drawn_bytes()) << size_px;
        // The bound in the proto's comment of Attach.resumable.
        ASSERT_LE(coding.sent_bytes_max(), coding.drawn_bytes() * 3 / 2 + 128) << size_px;
        ASSERT_EQ(ShapeOf(format).bytes(), format.bytes());
      }
    }
  }
}

}  // namespace
}  // namespace procgen
