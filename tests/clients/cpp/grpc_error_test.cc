#include "procgen_client/internal/grpc_error.h"

#include "gtest/gtest.h"

namespace procgen_client {
namespace {

TEST(GrpcErrorTest, ControlCharactersOfMessagesAreEscaped) {
  const grpc::Status status(grpc::StatusCode::NOT_FOUND,
                            "no pool \x1b]0;title\x07\x1b[2J\r\n\x7f \xc2\x9b");
  EXPECT_EQ(ToAbslStatus(status),
            absl::NotFoundError("no pool \\x1b]0;title\\x07\\x1b[2J\\x0d\\x0a\\x7f \\x9b"));
}

TEST(GrpcErrorTest, OtherCharactersOfMessagesStay) {
  const std::string message = "'\xc3\xa4' \xe2\x82\xac \xc2\xb5s is no game \\x";
  EXPECT_EQ(ToAbslStatus({grpc::StatusCode::NOT_FOUND, message}), absl::NotFoundError(message));
  EXPECT_EQ(ToAbslStatus({grpc::StatusCode::ABORTED, "\xc2"}), absl::AbortedError("\xc2"));
}

}  // namespace
}  // namespace procgen_client
