#include "server/rpc/unary_call.h"

#include "gmock/gmock.h"
#include "grpcpp/support/slice.h"
#include "gtest/gtest.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/pools.pb.h"

namespace procgen {
namespace {

grpc::ByteBuffer BytesOf(const std::string& bytes) {
  const grpc::Slice slice(bytes);
  return {&slice, 1};
}

TEST(ParseMessageTest, MessageWithoutFieldsHasNoBytes) {
  v1::GetLoadRequest message;
  EXPECT_TRUE(ParseMessage(BytesOf(""), &message).ok());
}

TEST(ParseMessageTest, GarbageIsToldWithItsSize) {
  v1::GetPoolRequest message;
  const absl::Status status = ParseMessage(BytesOf("\xff\xff"), &message);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(),
              testing::HasSubstr("2 bytes are no valid procgen.v1.GetPoolRequest"));
}

TEST(ParseMessageTest, CallsThatWereGivenUpBeforeTheirMessageCameAskedForNothingWrong) {
  v1::GetLoadRequest message;
  EXPECT_EQ(ParseMessage(grpc::ByteBuffer(), &message).code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace procgen
