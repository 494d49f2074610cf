// procgen-conformance must be able to fail: it is run on modified recordings.

#include <fstream>
#include <sstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/painted_art.h"
#include "tests/program_run.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

constexpr char kGoldenFolder[] = PROCGEN_SOURCE_DIR "/tests/conformance/golden/";
constexpr char kMaze[] = "maze.easy.solved-1000.trace";  // one environment, 59 steps

ProgramRun Replay(const std::string& arguments) {
  return RunProgram(absl::StrCat(PROCGEN_CONFORMANCE, " ", arguments));
}

std::string Contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream contents;
  contents << file.rdbuf();
  return contents.str();
}

std::string Written(const std::string& contents) {
  std::string path =
      absl::StrCat(testing::TempDir(), "/procgen_conformance_",
                   testing::UnitTest::GetInstance()->current_test_info()->name(), ".trace");
  std::ofstream(path, std::ios::binary) << contents;
  return path;
}

TEST(ProcgenConformanceTest, PassesOnGoldenRecordings) {
  const ProgramRun outcome = Replay(absl::StrCat("--workers 2 ", kGoldenFolder, kMaze, " ",
                                                 kGoldenFolder, "miner.easy.mono-restrict.trace"));
  EXPECT_EQ(outcome.exit_status, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("maze.easy.solved-1000.trace: ok\n"));
  EXPECT_THAT(outcome.output, HasSubstr("\n2 passed, 0 failed, 0 skipped\n"));
}

// The arrays follow the header: 59 bytes of actions, then 60 rows of rewards, and so on.
TEST(ProcgenConformanceTest, ChangedByteFailsAndIsNamed) {
  std::string contents = Contents(absl::StrCat(kGoldenFolder, kMaze));
  const size_t arrays = contents.find('\n') + 1;
  const size_t first = arrays + 59 + 60 * 4;
  contents[first + 4] ^= 1;
  const ProgramRun outcome = Replay(Written(contents));
  EXPECT_EQ(outcome.exit_status, 1);
  EXPECT_THAT(outcome.output, HasSubstr(": step 4, environment 0, first: expected 1, got 0\n"));
  EXPECT_THAT(outcome.output, HasSubstr("0 passed, 1 failed, 0 skipped\n"));
}

TEST(ProcgenConformanceTest, ChangedBitOfARewardFails) {
  std::string contents = Contents(absl::StrCat(kGoldenFolder, kMaze));
  contents[contents.find('\n') + 1 + 59 + 2 * 4] ^= 1;
  const ProgramRun outcome = Replay(Written(contents));
  EXPECT_EQ(outcome.exit_status, 1);
  EXPECT_THAT(outcome.output, HasSubstr(": step 2, environment 0, reward: expected "));
}

TEST(ProcgenConformanceTest, ChangedBitOfAnObservationDigestFails) {
  std::string contents = Contents(absl::StrCat(kGoldenFolder, "maze.memory.mono-restrict.trace"));
  contents.back() ^= 1;
  const ProgramRun outcome = Replay(Written(contents));
  EXPECT_EQ(outcome.exit_status, 1);
  EXPECT_THAT(outcome.output, HasSubstr(": step 200, environment 1, observation_fnv1a: expected "));
}

// Observations drawn with art are compared if and only if the program draws with an art folder.
TEST(ProcgenConformanceTest, ArtThatDiffersFromTheRecordingsFails) {
  const std::string recording = absl::StrCat(kGoldenFolder, "maze.easy.upstream-art.trace");
  const TemporaryFolder temporary;
  const std::string folder = temporary.At("painted");
  PaintArtFolder(folder);
  const ProgramRun painted = Replay(absl::StrCat("--art_dir ", folder, " ", recording));
  EXPECT_EQ(painted.exit_status, 1);
  EXPECT_THAT(painted.output, HasSubstr(": step 0, environment 0, observation_fnv1a: expected "));
  EXPECT_EQ(Replay(recording).exit_status, 0);
}

TEST(ProcgenConformanceTest, AMissingFileFails) {
  const ProgramRun outcome = Replay("/nowhere/at.all");
  EXPECT_EQ(outcome.exit_status, 1);
  EXPECT_THAT(outcome.output, HasSubstr("cannot open /nowhere/at.all"));
}

TEST(ProcgenConformanceTest, AnUnknownGameFails) {
  const std::string contents = Contents(absl::StrCat(kGoldenFolder, kMaze));
  const size_t header_size = contents.find('\n');
  const ProgramRun outcome = Replay(
      Written(absl::StrReplaceAll(contents.substr(0, header_size), {{"\"maze\"", "\"mazes\""}}) +
              contents.substr(header_size)));
  EXPECT_EQ(outcome.exit_status, 1);
  EXPECT_THAT(outcome.output, HasSubstr("no game is named \"mazes\""));
}

TEST(ProcgenConformanceTest, WithoutFilesItPrintsTheUsage) {
  const ProgramRun outcome = Replay("");
  EXPECT_EQ(outcome.exit_status, 2);
  EXPECT_THAT(outcome.output, HasSubstr("usage: procgen-conformance"));
  EXPECT_EQ(Replay(absl::StrCat("--workers 0 ", kGoldenFolder, kMaze)).exit_status, 2);
}

}  // namespace
}  // namespace procgen
