// Every limit of the server, exceeded.

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class LimitsTest : public ServiceTest {};

TEST_F(LimitsTest, TooManyPoolsAreRejected) {
  for (int i = 0; i < 3; ++i) {
    CreatePool(MazeSpec(1));
  }
  EXPECT_THAT(
      client_->CreatePool(MazeSpec(1)),
      StatusIs(absl::StatusCode::kResourceExhausted,
               HasSubstr("there are 4 pools, limit pool_count_max is 4; 3 of 4 own pools without "
                         "an attached learner")));
}

TEST_F(LimitsTest, TooManyEnvironmentsInOnePoolAreRejected) {
  EXPECT_THAT(client_->CreatePool(MazeSpec(501)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "spec.env_count is 501, limit pool_env_count_max is 500"));
}

TEST_F(LimitsTest, TooManyEnvironmentsInAllPoolsAreRejected) {
  const std::string name = CreatePool(MazeSpec(400));
  EXPECT_THAT(client_->CreatePool(MazeSpec(199)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("spec.env_count is 199 and there are 402 environments, limit "
                                 "env_count_max is 600; 1 of 2 own pools without")));
  ASSERT_THAT(client_->DeletePool(name), IsOk());
  EXPECT_THAT(client_->CreatePool(MazeSpec(199)), IsOk());
}

TEST_F(LimitsTest, AttachWithTooManyRequestsInFlightIsRejected) {
  procgen_client::StreamOptions options;
  options.requests_in_flight_max = 9;
  EXPECT_THAT(client_->Attach(CreatePool(MazeSpec(1)), options),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "attach.requests_in_flight_max is 9, limit requests_in_flight_max is 8"));
  options.requests_in_flight_max = -1;
  EXPECT_THAT(client_->Attach(CreatePool(MazeSpec(1)), options),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "attach.requests_in_flight_max is -1, allowed: 0 to 8"));
}

TEST_F(LimitsTest, AttachWithResponseLimitsOutOfRangeIsRejected) {
  procgen_client::StreamOptions options;
  options.response_bytes_max = (16 << 20) + 1;
  EXPECT_THAT(client_->Attach(CreatePool(MazeSpec(1)), options),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "attach.response_bytes_max is 16777217, limit response_bytes_max is "
                       "16777216"));
  options.response_bytes_max = 65535;
  EXPECT_THAT(client_->Attach(CreatePool(MazeSpec(1)), options),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "attach.response_bytes_max is 65535, allowed: 0, or 65536 to 16777216"));
}

TEST_F(LimitsTest, TooLargeRequestIsRejected) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  EXPECT_THAT(CallStatus(stream.get(), StepRequest(std::vector<int32_t>(70000, 4))),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("65536")));
}

TEST_F(LimitsTest, FramesBeyondAResponseAreRejected) {
  EXPECT_THAT(client_->RenderEnvironments(CreatePool(MazeSpec(6)), {0, 1, 2, 3, 4, 5}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "environments has 6 entries, limit response_bytes_max = 4194304 has room "
                       "for 5 frames of 512 x 512 pixels"));
}

}  // namespace
}  // namespace procgen
