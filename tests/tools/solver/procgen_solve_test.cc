// The output and the exit status of procgen-solve.

#include <fstream>
#include <iterator>
#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/program_run.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

ProgramRun Search(const std::string& flags) {
  return RunProgram(absl::StrCat(PROCGEN_SOLVE, " ", flags));
}

TEST(ProcgenSolveTest, ReportsSolvedAndUnsolvableLevels) {
  const ProgramRun run = Search("--games maze,jumper --first_level 4 --levels 2");
  EXPECT_EQ(run.exit_status, 0) << run.output;
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("| maze | easy | 2 of 2 | 0 | 0 |"),
                    HasSubstr("| jumper | easy | 1 of 2 | 1 | 0 |"),
                    HasSubstr("jumper easy: unsolvable: lost in the first step with every action: "
                              "5\n")));
}

TEST(ProcgenSolveTest, AnAbandonedLevelIsNamedAndFails) {
  const ProgramRun run = Search("--games climber --levels 1 --bursts 1");
  EXPECT_EQ(run.exit_status, 1);
  EXPECT_THAT(run.output, HasSubstr("climber easy: given up: 0\n"));
}

std::string WaysWithWorkers(int worker_count) {
  const TemporaryFolder temporary;
  const std::string path = temporary.At("ways");
  Search(absl::StrCat("--games leaper --levels 6 --workers ", worker_count, " --ways ", path));
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ProcgenSolveTest, SolutionsDoNotDependOnTheNumberOfWorkers) {
  const std::string alone = WaysWithWorkers(1);
  EXPECT_THAT(alone, HasSubstr("\nleaper easy 5: "));
  EXPECT_EQ(WaysWithWorkers(3), alone);
}

TEST(ProcgenSolveTest, WrongFlagsAreRejectedWithWhatIsAllowed) {
  EXPECT_EQ(Search("--levels 0").exit_status, 2);
  EXPECT_THAT(Search("--workers 0").output, HasSubstr("--workers 0: must be at least 1"));
  EXPECT_THAT(Search("--games bigfish").output,
              HasSubstr("game 'bigfish' is not one of caveflyer, climber, coinrun"));
  EXPECT_THAT(Search("--games heist --modes extreme").output,
              HasSubstr("mode 'extreme' is not one of heist's modes: easy, hard, memory"));
  EXPECT_THAT(Search("--games maze --levels 1 --ways /nowhere/at.all").output,
              HasSubstr("cannot write to /nowhere/at.all"));
  EXPECT_THAT(Search("maze").output,
              HasSubstr("unexpected argument 'maze': only flags are allowed"));
}

}  // namespace
}  // namespace procgen
