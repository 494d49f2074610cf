#include "envcore/render/art/art_dir.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/one_colour_png.h"
#include "tests/status_matchers.h"
#include "zlib.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr ArtSlot kFish = {0, 0, "fish", "sea/fish.png", 6, 4};
constexpr RequiredImage kFishPicture = {"sea/fish.png", 6, 4};
constexpr Rgba kRed = {255, 0, 0, 255};

// A temporary folder.
class ArtDirTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_ + "/sea"); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Write(const std::string& path, const std::string& bytes) const {
    std::ofstream(folder_ + "/" + path, std::ios::binary) << bytes;
  }

  absl::Status StatusOfReading(const std::vector<RequiredImage>& required) const {
    return ReadArtDir(folder_, required).status();
  }

  const std::string folder_ =
      absl::StrCat(testing::TempDir(), "/art_folder_",
                   testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(ArtDirTest, ImagesAreFoundBySlotAfterTheFolderIsDeleted) {
  Write("sea/fish.png", OneColourPng(6, 4, kRed));
  const auto pack = ReadArtDir(folder_ + "/", {kFishPicture});
  ASSERT_THAT(pack, IsOk());
  std::filesystem::remove_all(folder_);
  const MipmappedImage* fish = (*pack)->Sprite("bigfish", kFish);
  ASSERT_NE(fish, nullptr);
  EXPECT_EQ(fish->level(0).At(5, 3), kRed);
  EXPECT_EQ(fish->level_count(), 1);
}

TEST_F(ArtDirTest, AMissingFolderIsNamed) {
  EXPECT_THAT(ReadArtDir(folder_ + "/sky", {kFishPicture}),
              StatusIs(absl::StatusCode::kNotFound,
                       AllOf(HasSubstr("/sky'"), HasSubstr("there is no such folder"))));
}

TEST_F(ArtDirTest, TheFirstMissingFilesAreNamedAndTheOthersCounted) {
  Write("sea/fish.png", OneColourPng(6, 4, kRed));
  const std::vector<RequiredImage> required = {{"a.png"}, {"b.png"}, kFishPicture, {"c.png"},
                                               {"d.png"}, {"e.png"}, {"f.png"},    {"g.png"}};
  EXPECT_THAT(
      StatusOfReading(required),
      StatusIs(absl::StatusCode::kNotFound,
               AllOf(HasSubstr("7 of 8 images are missing or invalid: a.png is missing; b.png"),
                     HasSubstr("e.png is missing; and 2 more"), Not(HasSubstr("f.png")),
                     Not(HasSubstr("fish")))));
}

TEST_F(ArtDirTest, AWrongSizeIsReportedWithTheRequiredOne) {
  Write("sea/fish.png", OneColourPng(4, 6, kRed));
  EXPECT_THAT(StatusOfReading({kFishPicture}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("sea/fish.png is 4 x 6 pixels, must be 6 x 4")));
}

TEST_F(ArtDirTest, ATruncatedFileIsReported) {
  const std::string png = OneColourPng(6, 4, kRed);
  Write("sea/fish.png", png.substr(0, png.size() - 1));
  EXPECT_THAT(
      StatusOfReading({kFishPicture}),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("sea/fish.png is not a valid PNG")));
}

// A PNG file whose parts are sound, with `deflated` where its pixels should be.
std::string PngWith(const std::string& deflated, int width, int height) {
  const auto big_endian = [](size_t number) {
    std::string bytes;
    for (const int shift : {24, 16, 8, 0}) {
      bytes.push_back(static_cast<char>(number >> shift & 0xFF));
    }
    return bytes;
  };
  const auto part = [&](const std::string& type, const std::string& content) {
    const std::string checked = type + content;
    return absl::StrCat(big_endian(content.size()), checked,
                        big_endian(crc32(0, reinterpret_cast<const Bytef*>(checked.data()),
                                         static_cast<uInt>(checked.size()))));
  };
  const std::string kinds = {8, 6, 0, 0, 0};  // bits, RGBA, and the only ways there are
  return absl::StrCat("\x89PNG\r\n\x1a\n",
                      part("IHDR", big_endian(static_cast<size_t>(width)) +
                                       big_endian(static_cast<size_t>(height)) + kinds),
                      part("IDAT", deflated), part("IEND", ""));
}

TEST_F(ArtDirTest, AnUndecodableFileIsReported) {
  for (const std::string& deflated :
       {std::string(), std::string(300, 'x'), std::string("x\x9c\x03\x00\x00\x00\x00\x01", 8)}) {
    Write("sea/fish.png", PngWith(deflated, 6, 4));
    EXPECT_THAT(
        StatusOfReading({kFishPicture}),
        StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("sea/fish.png is not a valid PNG")));
  }
}

TEST_F(ArtDirTest, TheTotalNumberOfPixelsIsLimited) {
  std::vector<std::string> paths;
  std::vector<RequiredImage> required;
  required.reserve(4);
  for (int i = 0; i < 4; ++i) {
    paths.push_back(absl::StrCat("sea/", i, ".png"));
    // The file claims 67 million pixels, but contains 300 bytes of pixel data.
    Write(paths.back(), PngWith(std::string(300, 'x'), 8192, 8192));
  }
  for (const std::string& path : paths) {
    required.push_back({path});
  }
  EXPECT_THAT(StatusOfReading({required.back()}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("3.png is not a valid PNG")));
  EXPECT_THAT(StatusOfReading(required),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("sea/3.png is 8192 x 8192 pixels; all images together can have "
                                 "256000000 pixels")));
}

TEST_F(ArtDirTest, AFolderInPlaceOfAFileIsReported) {
  std::filesystem::create_directories(folder_ + "/sea/fish.png");
  EXPECT_THAT(StatusOfReading({kFishPicture}), StatusIs(absl::StatusCode::kInvalidArgument,
                                                        HasSubstr("sea/fish.png cannot be read")));
}

}  // namespace
}  // namespace procgen
