// The C++ client decodes exactly what was encoded: in every game and observation format, over
// hundreds of steps with ends, resets and new levels, in changing slices.

#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "gtest/gtest.h"
#include "procgen_client/observation_decoder.h"
#include "tests/server/encoding/encoded_play.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr int kStepCount = 200;

struct NamedFormat {
  std::string name;
  ObservationFormat format;
};

std::vector<NamedFormat> Formats() {
  return {
      {"Default", {}},
      {"Planes", {.frame = {64, Color::kRgb, Layout::kChw}}},
      {"Grey", {.frame = {84, Color::kGrayscale, Layout::kHwc}}},
      {"OddSide", {.frame = {43, Color::kRgb, Layout::kHwc}}},
      {"StackOfGreys", {.frame = {44, Color::kGrayscale, Layout::kChw}, .frame_stack = 4}},
      {"StackOfPlanes", {.frame = {20, Color::kRgb, Layout::kChw}, .frame_stack = 3}},
  };
}

std::vector<std::string> GameNames() {
  std::vector<std::string> names;
  for (const GameSpec& spec : GameCatalog()) {
    names.emplace_back(spec.name);
  }
  return names;
}

class RoundTripTest : public testing::TestWithParam<std::tuple<std::string, NamedFormat>> {};

TEST_P(RoundTripTest, ObservationsRoundTrip) {
  const auto& [game, format] = GetParam();
  EncodedPlay play({.game = game, .format = format.format});
  auto decoder = procgen_client::ObservationDecoder::Make(play.pool());
  ASSERT_THAT(decoder, IsOk());
  const ObservationCoding coding(format.format, Encoding::kDeltaZstd);
  for (int step = 0; step < kStepCount; ++step) {
    const EncodedAnswer answer = play.Next();
    ASSERT_LE(static_cast<int64_t>(answer.encoded.size()), answer.count * coding.sent_bytes_max());
    std::vector<uint8_t> decoded(answer.observations.size());
    ASSERT_THAT(
        decoder->Decode(answer.first, answer.count, answer.encoded, absl::MakeSpan(decoded)),
        IsOk());
    ASSERT_EQ(decoded, answer.observations) << "step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(All, RoundTripTest,
                         testing::Combine(testing::ValuesIn(GameNames()),
                                          testing::ValuesIn(Formats())),
                         [](const auto& info) {
                           return absl::StrCat(std::get<0>(info.param),
                                               std::get<1>(info.param).name);
                         });

TEST(RoundTripBytesTest, BytesDoNotDependOnTheNumberOfWorkers) {
  EncodedPlay alone({.game = "coinrun", .env_count = 8, .worker_count = 1});
  EncodedPlay three({.game = "coinrun", .env_count = 8, .worker_count = 3});
  for (int step = 0; step < kStepCount; ++step) {
    ASSERT_EQ(alone.Next().encoded, three.Next().encoded) << "step " << step;
  }
}

}  // namespace
}  // namespace procgen
