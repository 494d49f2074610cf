// The programs procgen-gallery and procgen-legibility: their output and their errors.

#include <fstream>
#include <iterator>
#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/painted_art.h"
#include "tests/program_run.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

ProgramRun Gallery(const std::string& arguments) {
  return RunProgram(absl::StrCat(PROCGEN_GALLERY, " ", arguments));
}

ProgramRun Legibility(const std::string& arguments) {
  return RunProgram(absl::StrCat(PROCGEN_LEGIBILITY, " ", arguments));
}

std::string Contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The width and height in the header of a PNG file.
std::string SizeOf(const std::string& path) {
  const std::string png = Contents(path);
  if (png.size() < 24 || png.compare(0, 8, "\x89PNG\r\n\x1a\n") != 0) {
    return "no PNG";
  }
  const auto number = [&](size_t at) {
    return static_cast<uint8_t>(png[at + 2]) * 256 + static_cast<uint8_t>(png[at + 3]);
  };
  return absl::StrCat(number(16), "x", number(20));
}

TEST(ProcgenGalleryTest, WritesTheSheetsOfAGame) {
  const TemporaryFolder temporary;
  const std::string folder = temporary.At("procgen gallery");
  const ProgramRun run = Gallery(absl::StrCat("'", folder, "' --games bigfish"));
  EXPECT_EQ(run.exit_status, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("[ 1/1] bigfish"));
  EXPECT_THAT(run.output, HasSubstr("/procgen gallery/games.png\n"));
  // Eight levels in two modes, each in the human and the agent's view.
  EXPECT_EQ(SizeOf(folder + "/bigfish.png"), "2476x1250");
  // Three themes of fish side by side, and the agent above them.
  EXPECT_EQ(SizeOf(folder + "/bigfish_sprites.png"), "1366x642");
  EXPECT_EQ(SizeOf(folder + "/pictures/bigfish_hard_7_agent.png"), "64x64");
  EXPECT_EQ(SizeOf(folder + "/pictures/bigfish_hard_7_human.png"), "512x512");
  EXPECT_NE(SizeOf(folder + "/shared_sprites.png"), "no PNG");
  EXPECT_NE(SizeOf(folder + "/games.png"), "no PNG");
}

TEST(ProcgenGalleryTest, WrongArgumentsAreRejectedWithWhatIsAllowed) {
  EXPECT_EQ(Gallery("").exit_status, 2);
  EXPECT_THAT(Gallery("").output, HasSubstr("expected 1 argument, the output folder, got 0"));
  EXPECT_THAT(Gallery("one two").output, HasSubstr("got 2"));
  EXPECT_THAT(Gallery("/nowhere --games chess").output,
              HasSubstr("game 'chess' is not one of bigfish, bossfight, "));
  EXPECT_THAT(Gallery("/dev/null/sheets --games maze").output,
              HasSubstr("cannot create the folder '/dev/null/sheets/pictures'"));
  EXPECT_THAT(Gallery("/nowhere --art_dir /no/art").output, HasSubstr("/no/art"));
}

TEST(ProcgenLegibilityTest, PrintsATableWithTheClosestPairInBold) {
  const ProgramRun run = Legibility("--games maze");
  EXPECT_EQ(run.exit_status, 0);
  EXPECT_THAT(run.output, HasSubstr("\n## maze\n\n| distance | part |"));
  EXPECT_THAT(run.output, HasSubstr("\n| **"));
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("| mouse | agent | cheese | pays | 0.0 | 2.0 |"),
                    HasSubstr("| wall | blocks | the backdrop | backdrop | 51.0 | – |")));
}

TEST(ProcgenLegibilityTest, APairBelowTheMinimumFails) {
  EXPECT_EQ(Legibility("--games maze --minimum 0.1").exit_status, 0);
  const ProgramRun run = Legibility("--games maze --minimum 1000");
  EXPECT_EQ(run.exit_status, 1);
  EXPECT_THAT(run.output, HasSubstr("6 pairs are below 1000\n"));
}

TEST(ProcgenLegibilityTest, ComparesContrastAndVarietyWithAnotherArt) {
  const TemporaryFolder temporary;
  PaintArtFolder(temporary.At("art"));
  const std::string flags = absl::StrCat("--games maze --compare_to ", temporary.At("art"));
  const ProgramRun run = Legibility(flags);
  EXPECT_EQ(run.exit_status, 0) << run.output;
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("| game | view | other art | ratio |"), HasSubstr("\n| mean | "),
                    HasSubstr("| game | lightness |"), ContainsRegex("\n\\| maze \\| [0-9]+ ± ")));
  const ProgramRun strict = Legibility(flags + " --minimum 1000");
  EXPECT_EQ(strict.exit_status, 1);
  EXPECT_THAT(strict.output, HasSubstr("1 games are below 1000\n"));
}

TEST(ProcgenLegibilityTest, WrongFlagsAreRejectedWithWhatIsAllowed) {
  EXPECT_EQ(Legibility("--minimum -1").exit_status, 2);
  EXPECT_THAT(Legibility("--minimum -1").output, HasSubstr("--minimum -1: must be at least 0"));
  EXPECT_THAT(Legibility("--games chess").output, HasSubstr("game 'chess' is not one of bigfish"));
  EXPECT_THAT(Legibility("maze").output,
              HasSubstr("unexpected argument 'maze': only flags are allowed"));
  EXPECT_EQ(Legibility("--compare_to /no/art").exit_status, 2);
  EXPECT_THAT(Legibility("--compare_to /no/art").output, HasSubstr("/no/art"));
}

}  // namespace
}  // namespace procgen
