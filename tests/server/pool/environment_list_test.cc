#include "server/pool/environment_list.h"

#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(EnvironmentListTest, DistinctEntriesInRangeAreValid) {
  EXPECT_THAT(CheckEnvironmentList({.list = "states", .environments = {3, 0, 2}}, "pools/7", 4),
              IsOk());
}

TEST(EnvironmentListTest, EmptyListIsRejected) {
  EXPECT_THAT(
      CheckEnvironmentList({.list = "states"}, "pools/7", 4),
      StatusIs(absl::StatusCode::kInvalidArgument, "states is empty, allowed: at least one"));
}

TEST(EnvironmentListTest, EntryOutOfRangeIsNamed) {
  for (const int32_t wrong : {-1, 4, INT32_MIN, INT32_MAX}) {
    EXPECT_THAT(
        CheckEnvironmentList(
            {.list = "states", .member = ".environment", .environments = {0, wrong}}, "pools/7", 4),
        StatusIs(absl::StatusCode::kInvalidArgument, "states[1].environment is " +
                                                         std::to_string(wrong) +
                                                         ", pool pools/7 has environments 0 to 3"));
  }
}

TEST(EnvironmentListTest, RepeatsAreRejectedUnlessAllowed) {
  const std::vector<int32_t> environments = {1, 2, 1};
  EnvironmentList list = {.list = "environments", .environments = environments};
  EXPECT_THAT(CheckEnvironmentList(list, "pools/7", 4),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "environments[2] is 1 again, allowed: each at most once"));
  list.repeats_allowed = true;
  EXPECT_THAT(CheckEnvironmentList(list, "pools/7", 4), IsOk());
}

}  // namespace
}  // namespace procgen
