#include "tools/course.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kKnown = {"heist", "maze"};

TEST(CourseTest, EachGameIsPlayedInEachMode) {
  const auto courses = MakeCourses({"maze", "heist"}, {"easy", "memory"}, kKnown);
  ASSERT_THAT(courses, IsOk());
  std::vector<std::string> names;
  for (const Course& course : *courses) {
    names.push_back(course.Name());
  }
  EXPECT_THAT(names,
              testing::ElementsAre("maze easy", "maze memory", "heist easy", "heist memory"));
}

TEST(CourseTest, AnUnknownGameIsAnsweredWithTheKnownOnes) {
  EXPECT_THAT(MakeCourses({"chess"}, {"easy"}, kKnown),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("game 'chess' is none of heist, maze")));
}

TEST(CourseTest, AModeThatAGameLacksIsAnsweredWithItsModes) {
  EXPECT_THAT(MakeCourses({"heist"}, {"extreme"}, kKnown),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("mode 'extreme' is none of heist's: easy, hard, memory")));
}

}  // namespace
}  // namespace procgen
