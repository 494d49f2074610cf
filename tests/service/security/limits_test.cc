// Every limit of the server, exceeded.

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class LimitsTest : public ServiceTest {};

TEST_F(LimitsTest, TooManyEnvironmentsAreRejected) {
  const auto run = StartPool(MazeSpec(400));
  EXPECT_THAT(StartError(MazeSpec(99)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "every caller together has 402 environments and asks for 99 more, limit "
                       "owner_env_count_max is 500"));
  EXPECT_THAT(run->Close(), IsOk());
  EXPECT_THAT(StartError(MazeSpec(99)), IsOk());
}

TEST_F(LimitsTest, TooManyCallsAreRejected) {
  Limits limits = TestLimits();
  limits.owner_call_count_max = 2;
  const auto server = StartServer(/*worker_count=*/1, limits);
  ASSERT_NE(server, nullptr);
  const auto channel = ChannelTo(server->address());
  const std::string message =
      "every caller together has 2 calls in progress and asks for 1 more, limit "
      "owner_call_count_max is 2";
  PoolStream run(channel);
  ASSERT_THAT(run.Start(MazeSpec(1)), IsOk());
  const auto client = procgen_client::Client::Connect(server->address());
  ASSERT_THAT(client, IsOk());
  v1::WatchPoolRequest request;
  request.set_pool(run.name());
  request.add_environments(0);
  auto watch = (*client)->Watch(request);
  ASSERT_THAT(watch->Next(), IsOk());
  EXPECT_THAT(PoolStream(channel).Start(MazeSpec(1)),
              StatusIs(absl::StatusCode::kResourceExhausted, message));
  EXPECT_THAT((*client)->GetLoad(), StatusIs(absl::StatusCode::kResourceExhausted, message));
  v1::Batch batch;
  EXPECT_THAT(run.Step({4}, &batch), IsOk());
  watch = nullptr;
  // The server detects the end of the watch a little later.
  while (absl::IsResourceExhausted((*client)->GetLoad().status())) {
  }
  EXPECT_THAT((*client)->GetLoad(), IsOk());
}

TEST_F(LimitsTest, TooLargeRequestIsRejected) {
  EXPECT_THAT(StartPool(MazeSpec(1))->Call(StepRequest(std::vector<int32_t>(70000, 4))),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("65536")));
}

TEST_F(LimitsTest, FramesBeyondAResponseAreRejected) {
  const std::vector<int32_t> environments(22, 0);
  EXPECT_THAT(StartPool(MazeSpec(1))->Render(environments),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "environments has 22 entries, limit response_bytes_max = 16777216 has room "
                       "for 21 frames of 512 x 512 pixels"));
}

TEST_F(LimitsTest, StatesBeyondAResponseAreRejected) {
  Limits limits = TestLimits();
  limits.response_bytes_max = 65536;
  const auto small = StartServer(/*worker_count=*/1, limits);
  ASSERT_NE(small, nullptr);
  PoolStream run(ChannelTo(small->address()));
  ASSERT_THAT(run.Start(MazeSpec(300)), IsOk());
  EXPECT_THAT(run.Save({0, 1, 2}), IsOk());
  EXPECT_THAT(run.Save(), StatusIs(absl::StatusCode::kResourceExhausted,
                                   HasSubstr("limit response_bytes_max is 65536; save fewer")));
}

}  // namespace
}  // namespace procgen
