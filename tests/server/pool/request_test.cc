#include "server/pool/request.h"

#include <vector>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

constexpr int32_t kRequestEnvCount = 4;

absl::Status Check(const Request& request) {
  return CheckRequest("pools/7", kRequestEnvCount, request);
}

Request StepOf(const std::vector<int32_t>& actions) {
  Request request;
  request.kind = Request::Kind::kStep;
  request.count = kRequestEnvCount;
  request.actions = actions;
  return request;
}

TEST(RequestTest, UnsetOrNegativeCountIsRejected) {
  for (const int32_t count : {0, -1, INT32_MIN}) {
    Request request;
    request.first = 1;
    request.count = count;
    EXPECT_THAT(Check(request),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         "slice.env_count is " + std::to_string(count) +
                             ", allowed from environment 1 of pool pools/7 on: 1 to 3"));
  }
}

TEST(RequestTest, SliceStartBeyondThePoolIsRejected) {
  Request request;
  request.first = 4;
  request.count = 1;
  EXPECT_THAT(Check(request),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "slice.first_env is 4, pool pools/7 has environments 0 to 3"));
}

TEST(RequestTest, SliceEndBeyondThePoolIsRejected) {
  Request request;
  request.first = 2;
  request.count = 3;
  EXPECT_THAT(
      Check(request),
      StatusIs(absl::StatusCode::kInvalidArgument,
               "slice.env_count is 3, allowed from environment 2 of pool pools/7 on: 1 to 2"));
}

TEST(RequestTest, OverflowingCountsAreRejected) {
  Request request;
  request.first = 3;
  request.count = INT32_MAX;
  EXPECT_THAT(Check(request),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("2147483647")));
}

TEST(RequestTest, WrongNumberOfActionsIsRejected) {
  const std::vector<int32_t> actions = {4, 4, 4};
  EXPECT_THAT(Check(StepOf(actions)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "actions has 3 entries, the slice of pool pools/7 has 4 environments"));
}

TEST(RequestTest, ActionsFromMinusOneTo14AreAllowed) {
  const std::vector<int32_t> actions = {-1, 0, 13, 14};
  EXPECT_THAT(Check(StepOf(actions)), IsOk());
}

TEST(RequestTest, ActionOutOfRangeIsRejected) {
  for (const int32_t action : {-2, 15, INT32_MIN, INT32_MAX}) {
    const std::vector<int32_t> actions = {4, 4, action, 4};
    EXPECT_THAT(Check(StepOf(actions)),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         "actions[2] is " + std::to_string(action) + ", allowed: -1 to 14"));
  }
}

TEST(RequestTest, RepeatOutOfRangeIsRejected) {
  const std::vector<int32_t> actions(kRequestEnvCount, 4);
  for (const int32_t repeat : {-1, 0, 1001}) {
    Request request = StepOf(actions);
    request.repeat = repeat;
    EXPECT_THAT(Check(request),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         "repeat_count is " + std::to_string(repeat) + ", allowed: 1 to 1000"));
  }
}

TEST(RequestTest, NextLevelOutsideTheSliceIsRejected) {
  const std::vector<int32_t> actions(2, 4);
  const std::vector<NextLevel> next_levels = {{1, 5}, {3, 5}};
  Request request = StepOf(actions);
  request.first = 1;
  request.count = 2;
  request.next_levels = next_levels;
  EXPECT_THAT(Check(request), StatusIs(absl::StatusCode::kInvalidArgument,
                                       "next_levels[1].environment is 3, the slice is 1 to 2"));
}

TEST(RequestTest, DuplicateResetIsRejected) {
  const std::vector<Reset> resets = {{2, {}, {}}, {0, {}, {}}, {2, {}, {}}};
  Request request;
  request.kind = Request::Kind::kReset;
  request.count = kRequestEnvCount;
  request.resets = resets;
  EXPECT_THAT(Check(request),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "resets[2].environment is 2 again, allowed: each at most once"));
}

TEST(RequestTest, EmptyResetIsRejected) {
  Request request;
  request.kind = Request::Kind::kReset;
  request.count = kRequestEnvCount;
  EXPECT_THAT(Check(request), StatusIs(absl::StatusCode::kInvalidArgument,
                                       "resets is empty, allowed: at least one environment"));
}

}  // namespace
}  // namespace procgen
