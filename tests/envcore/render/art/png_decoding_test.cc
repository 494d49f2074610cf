#include "envcore/render/art/png_decoding.h"

#include <string>

#include "gtest/gtest.h"
#include "tests/envcore/render/one_colour_png.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

std::string SmallPng() { return OneColourPng(3, 2, Rgba{10, 20, 30, 40}); }

TEST(PngDecodingTest, CheckingReturnsTheSizeOfTheDecodedImage) {
  const absl::StatusOr<PngSize> size = CheckPng(SmallPng());
  ASSERT_THAT(size, IsOk());
  EXPECT_EQ(size->width_px, 3);
  EXPECT_EQ(size->height_px, 2);
  const absl::StatusOr<Image> image = DecodePng(SmallPng(), AlphaUse::kIgnored);
  ASSERT_THAT(image, IsOk());
  EXPECT_EQ(image->width(), 3);
  EXPECT_EQ(image->height(), 2);
}

TEST(PngDecodingTest, CheckingDetectsEveryTruncation) {
  const std::string png = SmallPng();
  for (size_t size = 0; size < png.size(); ++size) {
    EXPECT_THAT(CheckPng(png.substr(0, size)), testing::Not(IsOk())) << size << " bytes";
  }
}

TEST(PngDecodingTest, CheckingDetectsEveryChangedBitThatDecodingRejects) {
  const std::string png = SmallPng();
  for (size_t bit = 0; bit < png.size() * 8; ++bit) {
    std::string changed = png;
    changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << (bit % 8)));
    if (CheckPng(changed).ok()) {
      EXPECT_THAT(DecodePng(changed, AlphaUse::kIgnored), IsOk()) << "bit " << bit;
    }
  }
}

TEST(PngDecodingTest, TooLargeSidesAreRejected) {
  EXPECT_THAT(CheckPng(OneColourPng(kPngSizePxMax + 1, 1, Rgba{})),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "is 8193 x 1 pixels, each side must be in [1, 8192]"));
}

}  // namespace
}  // namespace procgen
