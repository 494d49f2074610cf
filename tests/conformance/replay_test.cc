// Recordings of Procgen 0.10.7, replayed with one worker and with two: those of golden/, and those
// next to the checkout if there are any.

#include "tools/conformance/replay.h"

#include <filesystem>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_replace.h"
#include "envcore/pool/shared_art.h"
#include "envcore/trace/trace.h"
#include "gtest/gtest.h"
#include "procgen_client/local_pool.h"
#include "tests/conformance/recordings.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

std::string NameOf(const std::string& path) {
  return absl::StrReplaceAll(std::filesystem::path(path).stem().string(), {{".", "_"}, {"-", "_"}});
}

// Replays the file with `art` and returns the first difference or another error; empty: none.
std::string Replayed(const std::string& path, int32_t worker_count,
                     const std::shared_ptr<const SharedArt>& art = nullptr) {
  const absl::StatusOr<Trace> trace = ReadTrace(path);
  if (!trace.ok()) {
    return trace.status().ToString();
  }
  const bool with_pictures = trace->HasComparablePictures(art != nullptr);
  PoolOptions options = PoolOptionsOf(*trace);
  options.art = art;
  auto pool = procgen_client::LocalPool::Create(options, worker_count - 1);
  return pool.ok() ? FirstDifference(*trace, **pool, with_pictures)
                   : std::string(pool.status().message());
}

class GoldenReplayTest : public testing::TestWithParam<std::tuple<std::string, int32_t>> {};

TEST_P(GoldenReplayTest, MatchesTheRecording) {
  EXPECT_EQ(Replayed(std::get<0>(GetParam()), std::get<1>(GetParam())), "");
}

INSTANTIATE_TEST_SUITE_P(
    Files, GoldenReplayTest,
    testing::Combine(testing::ValuesIn(TracesIn(PROCGEN_SOURCE_DIR "/tests/conformance/golden")),
                     testing::Values(1, 2)),
    [](const auto& info) {
      return NameOf(std::get<0>(info.param)) + "_by_" + std::to_string(std::get<1>(info.param));
    });

class ReferenceReplayTest : public testing::TestWithParam<std::string> {};

TEST_P(ReferenceReplayTest, AllRecordingsMatch) {
  int count = 0;
  for (const char* folder : {"/rollouts", "/solved"}) {
    for (const std::string& path : TracesOf(GetParam(), ReferenceFolder() + folder)) {
      ++count;
      EXPECT_EQ(Replayed(path, 1), "") << path;
    }
  }
  if (count == 0) {
    GTEST_SKIP() << "no recordings of " << GetParam() << " next to the checkout";
  }
}

// With upstream's art, every pixel of the agent's view is that of upstream.
TEST_P(ReferenceReplayTest, AllObservationsMatchWithUpstreamArt) {
  const std::vector<std::string> paths = TracesOf(GetParam(), ReferenceFolder() + "/pixels");
  if (paths.empty() || UpstreamArtFolder().empty()) {
    GTEST_SKIP() << "no upstream art, or no recordings of it, next to the checkout";
  }
  const auto art = SharedArt::LoadFolder(UpstreamArtFolder());
  ASSERT_THAT(art, IsOk());
  for (const std::string& path : paths) {
    EXPECT_EQ(Replayed(path, 1, *art), "") << path;
    EXPECT_EQ(Replayed(path, 2, *art), "") << path << " by two workers";
  }
}

INSTANTIATE_TEST_SUITE_P(Catalog, ReferenceReplayTest, testing::ValuesIn(GamesOfTheCatalog()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace procgen
