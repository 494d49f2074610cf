#include "server/rpc/step/attach.h"

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

TEST(AttachTest, UnsetFieldsHaveDefaults) {
  v1::StepPoolRequest request;
  request.mutable_attach();
  const auto stream_options = ReadAttach(request, Limits());
  ASSERT_THAT(stream_options, IsOk());
  EXPECT_EQ(stream_options->attach.requests_in_flight_max, 2);
  EXPECT_FALSE(stream_options->attach.resumable);
  EXPECT_FALSE(stream_options->attach.take_over);
  EXPECT_EQ(stream_options->response_bytes_max, 4 << 20);
}

TEST(AttachTest, SetFieldsAreUsed) {
  v1::StepPoolRequest request;
  request.mutable_attach()->set_requests_in_flight_max(3);
  request.mutable_attach()->set_resumable(true);
  request.mutable_attach()->set_take_over(true);
  request.mutable_attach()->set_response_bytes_max(100'000);
  const auto stream_options = ReadAttach(request, Limits());
  ASSERT_THAT(stream_options, IsOk());
  EXPECT_EQ(stream_options->attach.requests_in_flight_max, 3);
  EXPECT_TRUE(stream_options->attach.resumable);
  EXPECT_TRUE(stream_options->attach.take_over);
  EXPECT_EQ(stream_options->response_bytes_max, 100'000);
}

TEST(AttachTest, HeldBatchesAreAcceptedAndReleasedOnesRejected) {
  v1::StepPoolRequest request;
  request.mutable_attach()->set_held_batches_max(5);
  request.mutable_attach()->add_held_batches(3);
  const auto stream_options = ReadAttach(request, Limits());
  ASSERT_THAT(stream_options, IsOk());
  EXPECT_EQ(stream_options->attach.held_batches_max, 5);
  EXPECT_THAT(stream_options->attach.held_batches, testing::ElementsAre(3));
  request.mutable_attach()->set_held_batches_max(1025);
  EXPECT_THAT(ReadAttach(request, Limits()),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed: 0 to 1024")));
  request.mutable_attach()->set_held_batches_max(-1);
  EXPECT_THAT(ReadAttach(request, Limits()),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("held_batches_max is -1")));
  request.mutable_attach()->set_held_batches_max(0);
  request.add_released_batches(3);
  EXPECT_THAT(ReadAttach(request, Limits()),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("released_batches has 1")));
}

TEST(AttachTest, OtherMessagesAreRejected) {
  v1::StepPoolRequest request;
  request.mutable_observe();
  EXPECT_THAT(ReadAttach(request, Limits()),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("has no attach")));
  request.mutable_attach();
  request.set_sequence_number(5);
  EXPECT_THAT(ReadAttach(request, Limits()),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("sequence_number is 5")));
}

}  // namespace
}  // namespace procgen
