#include "server/rpc/call/unary_call.h"

#include <array>
#include <string>

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

TEST(ParseMessageTest, PiecesAreReadAsOne) {
  v1::GetPoolRequest sent;
  sent.set_name("pools/of-more-bytes-than-a-slice-holds-in-itself");
  const std::string bytes = sent.SerializeAsString();
  const std::array<grpc::Slice, 2> pieces = {grpc::Slice(bytes.substr(0, 10)),
                                             grpc::Slice(bytes.substr(10))};
  for (const grpc::ByteBuffer& buffer :
       {BytesOf(bytes), grpc::ByteBuffer(pieces.data(), pieces.size())}) {
    v1::GetPoolRequest message;
    EXPECT_TRUE(ParseMessage(buffer, &message).ok());
    EXPECT_EQ(message.name(), sent.name());
  }
}

TEST(ParseMessageTest, InvalidMessageErrorNamesItsSize) {
  v1::GetPoolRequest message;
  const absl::Status status = ParseMessage(BytesOf("\xff\xff"), &message);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(),
              testing::HasSubstr("2 bytes are not a valid procgen.v1.GetPoolRequest"));
}

}  // namespace
}  // namespace procgen
