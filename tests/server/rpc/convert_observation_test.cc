#include "server/rpc/convert_observation.h"

#include <optional>

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

TEST(ConvertObservationTest, EncodingsAreThoseOfTheContract) {
  EXPECT_EQ(*CompressionOf(v1::PoolSpec()), std::nullopt);
  for (const v1::Encoding encoding :
       {v1::ENCODING_RAW, v1::ENCODING_ZSTD_DIFFERENCE, v1::ENCODING_LZ4_DIFFERENCE}) {
    const auto compression = CompressionOf(SpecWith(encoding));
    ASSERT_THAT(compression, IsOk());
    EXPECT_EQ(EncodingMessageOf(*compression), encoding);
  }
}

TEST(ConvertObservationTest, UnknownEncodingsAreRefused) {
  EXPECT_THAT(CompressionOf(SpecWith(static_cast<v1::Encoding>(9))),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "spec.encoding is number 9, allowed: ENCODING_RAW, "
                       "ENCODING_ZSTD_DIFFERENCE, ENCODING_LZ4_DIFFERENCE"));
}

TEST(ConvertObservationTest, SharedMemoryIsNotEncoded) {
  v1::PoolSpec spec = SpecWith(v1::ENCODING_LZ4_DIFFERENCE);
  spec.set_transport(v1::TRANSPORT_SHARED_MEMORY);
  EXPECT_THAT(CompressionOf(spec),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "spec.encoding is ENCODING_LZ4_DIFFERENCE, allowed with "
                       "TRANSPORT_SHARED_MEMORY: ENCODING_RAW, as nothing is sent"));
  spec.set_encoding(v1::ENCODING_RAW);
  EXPECT_THAT(CompressionOf(spec), IsOk());
}

}  // namespace
}  // namespace procgen
