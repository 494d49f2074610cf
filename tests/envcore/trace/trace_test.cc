#include "envcore/trace/trace.h"

#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

constexpr char kGolden[] =
    PROCGEN_SOURCE_DIR "/tests/conformance/golden/maze.easy.solved-1000.trace";

std::string Contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream contents;
  contents << file.rdbuf();
  return contents.str();
}

// The result of reading a file with these contents.
absl::StatusOr<Trace> ReadContents(const std::string& contents) {
  const std::string path =
      absl::StrCat(testing::TempDir(), "/",
                   testing::UnitTest::GetInstance()->current_test_info()->name(), ".trace");
  std::ofstream(path, std::ios::binary) << contents;
  return ReadTrace(path);
}

// The golden file with one part of its header replaced.
std::string Changed(const std::string& before, const std::string& after) {
  const std::string contents = Contents(kGolden);
  const size_t header_size = contents.find('\n');
  const std::string header =
      absl::StrReplaceAll(contents.substr(0, header_size), {{before, after}});
  return header + contents.substr(header_size);
}

void ExpectDataLoss(const std::string& contents, const std::string& message) {
  const absl::Status status = ReadContents(contents).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), HasSubstr(message));
}

TEST(TraceTest, ReadsTheFieldsOfTheHeader) {
  const absl::StatusOr<Trace> trace = ReadTrace(kGolden);
  ASSERT_TRUE(trace.ok()) << trace.status();
  EXPECT_THAT(trace->games, testing::ElementsAre("maze"));
  EXPECT_EQ(trace->options.distribution_mode, DistributionMode::kEasy);
  EXPECT_EQ(trace->options.num_levels, 1);
  EXPECT_EQ(trace->options.start_level, 1000);
  EXPECT_EQ(trace->env_count, 1);
  EXPECT_EQ(trace->step_count, 59);
  EXPECT_EQ(trace->actions.size(), 59U);
  EXPECT_EQ(trace->rewards.size(), 60U);
  EXPECT_FALSE(trace->HasComparablePictures(true));
}

TEST(TraceTest, OnlyObservationsOfUpstreamArtNeedItForComparison) {
  for (const auto& [file, need_art] : {std::pair("maze.easy.upstream-art.trace", true),
                                       std::pair("maze.easy.generated-pictures.trace", false),
                                       std::pair("maze.memory.mono-restrict.trace", false)}) {
    const auto trace =
        ReadTrace(absl::StrCat(PROCGEN_SOURCE_DIR, "/tests/conformance/golden/", file));
    ASSERT_TRUE(trace.ok()) << trace.status();
    EXPECT_EQ(trace->HasComparablePictures(false), !need_art) << file;
    EXPECT_TRUE(trace->HasComparablePictures(true)) << file;
  }
}

TEST(TraceTest, ATruncatedFileErrorNamesTheArray) {
  const std::string contents = Contents(kGolden);
  ExpectDataLoss(contents.substr(0, contents.size() - 1),
                 "the file ends within array prev_level_complete");
  ExpectDataLoss(contents.substr(0, contents.find('\n') + 10), "the file ends within array action");
}

TEST(TraceTest, AFileThatIsNotATraceIsRejected) {
  ExpectDataLoss("", "invalid trace header");
  ExpectDataLoss("PNG\n", "invalid trace header: the first line is not JSON");
  ExpectDataLoss("{}\n", "invalid trace header: key 'format' not found");
  ExpectDataLoss(Changed("procgen-trace-1", "procgen-trace-9"),
                 "format is \"procgen-trace-9\", must be procgen-trace-1");
}

TEST(TraceTest, ImpossibleNumbersAreRejected) {
  ExpectDataLoss(Changed(R"("num_envs":1)", R"("num_envs":0)"),
                 "num_envs is 0, must be at least 1");
  ExpectDataLoss(Changed(R"("num_envs":1)", R"("num_envs":-4)"),
                 "num_envs is -4, must be at least 1");
  ExpectDataLoss(Changed(R"("steps":59)", R"("steps":-1)"), "steps is -1, must be at least 0");
  ExpectDataLoss(Changed(R"("steps":59)", R"("steps":58)"), "wrong number of rows");
  ExpectDataLoss(Changed(R"(["action","u1",59])", R"(["action","u1",9223372036854775807])"),
                 "within array action, which has 9223372036854775807 rows of 1");
  ExpectDataLoss(Changed(R"(["action","u1",59])", R"(["action","u9",59])"),
                 "array action has type u9");
}

TEST(TraceTest, ClaimedSizesBeyondTheFileTakeNoMemory) {
  ExpectDataLoss(Changed(R"("num_envs":1)", R"("num_envs":2147483647)"),
                 "ends within array action");
}

TEST(TraceTest, ArraysThatAreMissingOrOfAnotherTypeAreNamed) {
  ExpectDataLoss(Changed(R"("level_seed")", R"("level_sead")"), "array level_seed is missing");
  ExpectDataLoss(Changed(R"(["reward","f4")", R"(["reward","i4")"),
                 "array reward has type i4, must be f4");
}

TEST(TraceTest, WritingAndReadingRoundTrips) {
  absl::StatusOr<Trace> trace = ReadTrace(kGolden);
  ASSERT_TRUE(trace.ok()) << trace.status();
  // Byte for byte: the recordings were written by another program.
  EXPECT_EQ(TraceFileOf(*trace), Contents(kGolden));

  trace->actions[3] = kEndEpisodeAction;
  trace->observation_digests.assign(60, 7);
  trace->fingerprints = {{0xffffffffffffffffU, 1}};
  const absl::StatusOr<Trace> again = ParseTrace(TraceFileOf(*trace));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->actions, trace->actions);
  EXPECT_EQ(again->observation_digests, trace->observation_digests);
  EXPECT_EQ(again->fingerprints, trace->fingerprints);
}

TEST(TraceTest, InvalidFingerprintsAreRejected) {
  const auto with = [](const std::string& fingerprints) {
    return Changed(R"("num_envs":1)",
                   absl::StrCat(R"("num_envs":1,"fingerprints":)", fingerprints));
  };
  EXPECT_TRUE(ReadContents(with(R"([["0123456789abcdef"]])")).ok());
  ExpectDataLoss(with(R"([["0123456789abcde"]])"), R"("0123456789abcde" is not a fingerprint)");
  ExpectDataLoss(with(R"([["0123456789abcdeg"]])"), "is not a fingerprint");
  ExpectDataLoss(with("[]"), "fingerprints has 0 lists, must have 1");
  ExpectDataLoss(with("[[7]]"), "invalid trace header");
}

TEST(TraceTest, AnUnknownModeIsNamed) {
  ExpectDataLoss(Changed(R"("distribution_mode":"easy")", R"("distribution_mode":"medium")"),
                 R"(no distribution mode is named "medium")");
}

TEST(TraceTest, AVariantIsKeptAndAnUnknownOneIsNamed) {
  absl::StatusOr<Trace> trace = ReadTrace(kGolden);
  ASSERT_TRUE(trace.ok()) << trace.status();
  EXPECT_EQ(trace->options.variant, Variant::kNone);
  trace->options.variant = Variant::kCheeseCorner;
  EXPECT_EQ(ParseTrace(TraceFileOf(*trace)).value().options.variant, Variant::kCheeseCorner);
  trace->options.variant = Variant::kGravity;
  trace->options.variant_value = 0.1F;
  const Trace read = ParseTrace(TraceFileOf(*trace)).value();
  EXPECT_EQ(read.options.variant, Variant::kGravity);
  EXPECT_EQ(read.options.variant_value, 0.1F);
  ExpectDataLoss(Changed(R"("debug_mode":0)", R"("debug_mode":0,"variant":"blue")"),
                 "variant is blue, must be one of coin_random (coinrun)");
}

}  // namespace
}  // namespace procgen
