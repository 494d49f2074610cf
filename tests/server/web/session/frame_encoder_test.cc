#include "server/web/session/frame_encoder.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen::web {
namespace {

using testing::SizeIs;

constexpr int32_t kSizePx = 64;

procgen::v1::WatchPoolResponse FramesOf(const std::string& first, const std::string& second) {
  procgen::v1::WatchPoolResponse response;
  response.set_request_count(7);
  for (const std::string& image : {first, second}) {
    procgen::v1::Frame* frame = response.add_frames();
    frame->set_environment(response.frames_size() == 1 ? 3 : 5);
    frame->set_size_px(kSizePx);
    frame->set_image(image);
  }
  return response;
}

std::string Pixels(char value) {
  std::string pixels(kSizePx * kSizePx * 3, value);
  return pixels;
}

Json HeaderOf(const WireMessage& message) {
  uint32_t length = 0;
  std::memcpy(&length, message.bytes.data(), sizeof(length));
  return Json::parse(message.bytes.substr(sizeof(length), length));
}

TEST(FrameEncoderTest, FramesHaveTheirEnvironmentsAndSizes) {
  DifferenceCache differences;
  FrameEncoder encoder(9, FrameEncoding::kRgb, &differences);
  const Json header = HeaderOf(encoder.Encode(FramesOf(Pixels('a'), Pixels('b'))));
  EXPECT_EQ(header["event"], "frames");
  EXPECT_EQ(header["watch"], 9);
  EXPECT_EQ(header["request_count"], 7);
  ASSERT_THAT(header["parts"], SizeIs(2));
  const Json second = {{"name", "environment-5"}, {"format", "rgb"},   {"environment", 5},
                       {"width", kSizePx},        {"height", kSizePx}, {"bytes", 12288}};
  EXPECT_EQ(header["parts"][1], second);
}

TEST(FrameEncoderTest, UnchangedFramesAreEmpty) {
  DifferenceCache differences;
  FrameEncoder encoder(1, FrameEncoding::kDeflate, &differences);
  const Json first = HeaderOf(encoder.Encode(FramesOf(Pixels('a'), Pixels('b'))));
  EXPECT_GT(first["parts"][0]["bytes"], 0);
  const Json second = HeaderOf(encoder.Encode(FramesOf(Pixels('a'), Pixels('c'))));
  EXPECT_EQ(second["parts"][0]["format"], "deflate");
  EXPECT_EQ(second["parts"][0]["bytes"], 0);
  EXPECT_GT(second["parts"][1]["bytes"], 0);
}

TEST(FrameEncoderTest, PagesThatShowTheSameFramesShareDifferences) {
  DifferenceCache differences;
  FrameEncoder first(1, FrameEncoding::kDeflate, &differences);
  first.Encode(FramesOf(Pixels('a'), Pixels('b')));
  // A page that is opened later has the same frames from its second frame set on.
  FrameEncoder second(1, FrameEncoding::kDeflate, &differences);
  const std::string of_first = first.Encode(FramesOf(Pixels('c'), Pixels('d'))).bytes;
  EXPECT_NE(second.Encode(FramesOf(Pixels('c'), Pixels('d'))).bytes, of_first);
  const size_t count = differences.count();
  const std::string next = first.Encode(FramesOf(Pixels('e'), Pixels('f'))).bytes;
  EXPECT_EQ(differences.count(), count + 2);
  EXPECT_EQ(second.Encode(FramesOf(Pixels('e'), Pixels('f'))).bytes, next);
  EXPECT_EQ(differences.count(), count + 2);
}

}  // namespace
}  // namespace procgen::web
