#include "server/wire/response_limit.h"

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(ResponseLimitTest, UnsetIsTheDefaultOrTheLimit) {
  Limits limits;
  EXPECT_EQ(ResponseBytesMax("bytes", 0, limits).value(), kResponseBytesDefault);
  limits.response_bytes_max = 100000;
  EXPECT_EQ(ResponseBytesMax("bytes", 0, limits).value(), 100000);
}

TEST(ResponseLimitTest, RangeIsInclusive) {
  Limits limits;
  limits.response_bytes_max = 100000;
  EXPECT_EQ(ResponseBytesMax("bytes", 65536, limits).value(), 65536);
  EXPECT_EQ(ResponseBytesMax("bytes", 100000, limits).value(), 100000);
  EXPECT_THAT(ResponseBytesMax("bytes", 65535, limits),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "bytes is 65535, allowed: 0, or 65536 to 100000"));
  EXPECT_THAT(ResponseBytesMax("bytes", 100001, limits),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "bytes is 100001, limit response_bytes_max is 100000"));
}

}  // namespace
}  // namespace procgen
