#include "server/rpc/grpc/grpc_status.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(GrpcStatusTest, CodeAndMessageAreKept) {
  const grpc::Status status = ToGrpcStatus(absl::ResourceExhaustedError("too many"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(status.error_message(), "too many");
  EXPECT_TRUE(ToGrpcStatus(absl::OkStatus()).ok());
}

}  // namespace
}  // namespace procgen
