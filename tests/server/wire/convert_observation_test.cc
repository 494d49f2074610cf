#include "server/wire/convert_observation.h"

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

v1::PoolSpec SpecWith(v1::Encoding encoding) {
  v1::PoolSpec spec;
  spec.set_encoding(encoding);
  return spec;
}

TEST(ConvertObservationTest, EncodingsMatchTheProto) {
  EXPECT_EQ(*EncodingOf(v1::PoolSpec()), Encoding::kRaw);
  for (const v1::Encoding message : {v1::ENCODING_RAW, v1::ENCODING_DELTA_ZSTD}) {
    const auto encoding = EncodingOf(SpecWith(message));
    ASSERT_THAT(encoding, IsOk());
    EXPECT_EQ(EncodingMessageOf(*encoding), message);
  }
}

TEST(ConvertObservationTest, UnknownEncodingsAreRejected) {
  // 3 was LZ4.
  for (const int number : {3, 9}) {
    EXPECT_THAT(EncodingOf(SpecWith(static_cast<v1::Encoding>(number))),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         absl::StrCat("spec.encoding is number ", number,
                                      ", allowed: ENCODING_RAW, ENCODING_DELTA_ZSTD")));
  }
}

}  // namespace
}  // namespace procgen
