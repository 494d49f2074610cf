#include "server/pool/request.h"

#include <vector>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

const std::vector<int32_t> kActions(4, 4);

// A request for the environments from `first` on of a pool of four.
Request RequestOf(Request::Kind kind, int32_t first, int32_t count,
                  absl::Span<const int32_t> actions = {}) {
  Request request;
  request.kind = kind;
  request.first = first;
  request.count = count;
  request.actions = actions;
  return request;
}

void ExpectInvalid(const Request& request, const std::string& message) {
  EXPECT_THAT(CheckRequest("pools/7", 4, request),
              StatusIs(absl::StatusCode::kInvalidArgument, message));
}

TEST(RequestTest, SlicesBeyondThePoolAreRejected) {
  for (const auto& [first, count, range] : {std::tuple{1, 0, "1 to 3"},
                                            {1, -1, "1 to 3"},
                                            {1, INT32_MIN, "1 to 3"},
                                            {2, 3, "1 to 2"},
                                            {3, INT32_MAX, "1 to 1"}}) {
    ExpectInvalid(RequestOf(Request::Kind::kObserve, first, count),
                  absl::StrCat("slice.env_count is ", count, ", allowed from environment ", first,
                               " of pool pools/7 on: ", range));
  }
  ExpectInvalid(RequestOf(Request::Kind::kObserve, 4, 1),
                "slice.first_env is 4, pool pools/7 has environments 0 to 3");
}

TEST(RequestTest, OneActionFromMinusOneTo14IsNeededForEachEnvironment) {
  std::vector<int32_t> actions = {-1, 0, 13, 14};
  EXPECT_THAT(CheckRequest("pools/7", 4, RequestOf(Request::Kind::kStep, 0, 4, actions)), IsOk());
  for (const int32_t action : {-2, 15, INT32_MIN, INT32_MAX}) {
    actions[2] = action;
    ExpectInvalid(RequestOf(Request::Kind::kStep, 0, 4, actions),
                  absl::StrCat("actions[2] is ", action, ", allowed: -1 to 14"));
  }
  actions.pop_back();
  ExpectInvalid(RequestOf(Request::Kind::kStep, 0, 4, actions),
                "actions has 3 entries, the slice of pool pools/7 has 4 environments");
}

TEST(RequestTest, RepeatOutOfRangeIsRejected) {
  for (const int32_t repeat : {-1, 0, 1001}) {
    Request request = RequestOf(Request::Kind::kStep, 0, 4, kActions);
    request.repeat = repeat;
    ExpectInvalid(request, absl::StrCat("repeat_count is ", repeat, ", allowed: 1 to 1000"));
  }
}

TEST(RequestTest, NextLevelOutsideTheSliceIsRejected) {
  const std::vector<NextLevel> next_levels = {{1, 5}, {3, 5}};
  Request request =
      RequestOf(Request::Kind::kStep, 1, 2, absl::MakeConstSpan(kActions).subspan(0, 2));
  request.next_levels = next_levels;
  ExpectInvalid(request, "next_levels[1].environment is 3, the slice is 1 to 2");
}

TEST(RequestTest, ResetsThatAreMissingOrRepeatedAreRejected) {
  Request request = RequestOf(Request::Kind::kReset, 0, 4);
  ExpectInvalid(request, "resets is empty, allowed: at least one environment");
  const std::vector<Reset> resets = {{2, {}, {}}, {0, {}, {}}, {2, {}, {}}};
  request.resets = resets;
  ExpectInvalid(request, "resets[2].environment is 2 again, allowed: each at most once");
}

}  // namespace
}  // namespace procgen
