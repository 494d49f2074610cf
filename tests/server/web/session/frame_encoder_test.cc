#include "server/web/session/frame_encoder.h"

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
  response.set_sequence_number(7);
  for (const std::string& image : {first, second}) {
    procgen::v1::Frame* frame = response.add_frames();
    frame->set_environment(response.frames_size() == 1 ? 3 : 5);
    frame->set_size_px(kSizePx);
    frame->set_image(image);
  }
  return response;
}

std::string Pixels(char value) { return std::string(kSizePx * kSizePx * 3, value); }

Json HeaderOf(const WireMessage& message) {
  uint32_t length = 0;
  std::memcpy(&length, message.bytes.data(), sizeof(length));
  return Json::parse(message.bytes.substr(sizeof(length), length));
}

TEST(FrameEncoderTest, FramesHaveTheirEnvironmentsAndSizes) {
  FrameEncoder encoder(9, FrameEncoding::kRgb);
  const Json header = HeaderOf(encoder.Encode(FramesOf(Pixels('a'), Pixels('b'))));
  EXPECT_EQ(header["event"], "frames");
  EXPECT_EQ(header["watch"], 9);
  EXPECT_EQ(header["sequence_number"], 7);
  ASSERT_THAT(header["parts"], SizeIs(2));
  const Json second = {{"name", "environment-5"}, {"format", "rgb"},   {"environment", 5},
                       {"width", kSizePx},        {"height", kSizePx}, {"bytes", 12288}};
  EXPECT_EQ(header["parts"][1], second);
}

TEST(FrameEncoderTest, UnchangedFramesAreEmpty) {
  FrameEncoder encoder(1, FrameEncoding::kDeflate);
  const Json first = HeaderOf(encoder.Encode(FramesOf(Pixels('a'), Pixels('b'))));
  EXPECT_GT(first["parts"][0]["bytes"], 0);
  const Json second = HeaderOf(encoder.Encode(FramesOf(Pixels('a'), Pixels('c'))));
  EXPECT_EQ(second["parts"][0]["format"], "deflate");
  EXPECT_EQ(second["parts"][0]["bytes"], 0);
  EXPECT_GT(second["parts"][1]["bytes"], 0);
}

}  // namespace
}  // namespace procgen::web
