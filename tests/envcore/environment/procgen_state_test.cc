// The program procgen-state, run on snapshots of a game and on invalid files.

#include <fstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "envcore/environment/environment.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/program_run.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

ProgramRun RunState(absl::string_view arguments) {
  return RunProgram(absl::StrCat(PROCGEN_STATE, " ", arguments));
}

std::string MinerSnapshot() {
  Environment environment(*FindGame("miner"), *ResolveOptions("miner", {}), 1,
                          AutoresetMode::kSameStep);
  environment.SetNextLevel(77);
  environment.Step(7, 1, [] {});
  return environment.SaveState().value();
}

std::string Written(const std::string& contents) {
  std::string path =
      absl::StrCat(testing::TempDir(), "/procgen_state_",
                   testing::UnitTest::GetInstance()->current_test_info()->name(), ".pgst");
  std::ofstream(path, std::ios::binary) << contents;
  return path;
}

TEST(ProcgenStateTest, ASnapshotIsPrintedWithItsFields) {
  const ProgramRun outcome = RunState(absl::StrCat("dump ", Written(MinerSnapshot())));
  EXPECT_EQ(outcome.exit_status, 0) << outcome.output;
  const auto tree = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(tree["game"], "miner");
  EXPECT_EQ(tree["next_level"], 77);
  EXPECT_EQ(tree["level"]["step_number"], 1);
  EXPECT_EQ(tree["entities"][0]["kind"], "exit");
  EXPECT_EQ(tree["edited"], false);
  EXPECT_THAT(outcome.output, HasSubstr("\n\"options\": {\"distribution_mode\":1,"));
}

TEST(ProcgenStateTest, ThePrintedJsonIsEncodedToTheSameSnapshot) {
  const std::string snapshot = MinerSnapshot();
  const std::string path = Written(snapshot);
  const ProgramRun outcome =
      RunState(absl::StrCat("dump ", path, " | ", PROCGEN_STATE, " encode - | cmp - ", path));
  EXPECT_EQ(outcome.exit_status, 0) << outcome.output;
}

TEST(ProcgenStateTest, AStateThatNoLevelCanHaveIsRejected) {
  const ProgramRun outcome = RunState(absl::StrCat("encode ", Written(R"({"game": "pong"})")));
  EXPECT_EQ(outcome.exit_status, 1);
  EXPECT_THAT(outcome.output, HasSubstr("procgen-state: game: no game is named \"pong\""));
}

TEST(ProcgenStateTest, AFileThatCannotBeReadIsNamed) {
  for (const std::string path : {"/nowhere/at.all", "/"}) {
    const ProgramRun outcome = RunState(absl::StrCat("dump ", path));
    EXPECT_EQ(outcome.exit_status, 2);
    EXPECT_EQ(outcome.output, absl::StrCat("procgen-state: cannot read ", path, "\n"));
  }
}

TEST(ProcgenStateTest, ADamagedSnapshotIsRejected) {
  std::string snapshot = MinerSnapshot();
  snapshot.back() = static_cast<char>(snapshot.back() ^ 1);
  const ProgramRun outcome = RunState(absl::StrCat("dump ", Written(snapshot)));
  EXPECT_EQ(outcome.exit_status, 1);
  EXPECT_EQ(outcome.output, "procgen-state: the snapshot's checksum does not match its body\n");
}

TEST(ProcgenStateTest, WrongArgumentsPrintTheUsage) {
  for (const std::string arguments : {"", "dump", "dump a b", "load a"}) {
    const ProgramRun outcome = RunState(arguments);
    EXPECT_EQ(outcome.exit_status, 2) << arguments;
    EXPECT_THAT(outcome.output, HasSubstr("usage: procgen-state dump FILE\n"));
  }
}

}  // namespace
}  // namespace procgen
