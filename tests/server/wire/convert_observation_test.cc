#include "server/wire/convert_observation.h"

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(ConvertObservationTest, EncodingsMatchTheProto) {
  EXPECT_EQ(*EncodingOf("spec.encoding", v1::ENCODING_UNSPECIFIED), Encoding::kRaw);
  for (const v1::Encoding message : {v1::ENCODING_RAW, v1::ENCODING_DELTA_ZSTD}) {
    const auto encoding = EncodingOf("spec.encoding", message);
    ASSERT_THAT(encoding, IsOk());
    EXPECT_EQ(EncodingMessageOf(*encoding), message);
  }
}

TEST(ConvertObservationTest, UnknownEncodingsAreRejected) {
  // 3 was LZ4.
  for (const int number : {3, 9}) {
    EXPECT_THAT(EncodingOf("spec.encoding", static_cast<v1::Encoding>(number)),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         absl::StrCat("spec.encoding is number ", number,
                                      ", allowed: ENCODING_RAW, ENCODING_DELTA_ZSTD")));
  }
}

}  // namespace
}  // namespace procgen
