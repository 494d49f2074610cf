#include "envcore/random/random_stream.h"

#include <numeric>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

TEST(RandomStreamTest, OutputsAreThoseOfMt19937) {
  RandomStream zero(0);
  EXPECT_EQ(zero.Raw(), 2357136044U);
  EXPECT_EQ(zero.Raw(), 2546248239U);
  EXPECT_EQ(zero.Raw(), 3071714933U);
  EXPECT_EQ(RandomStream(1).Raw(), 1791095845U);
}

TEST(RandomStreamTest, NegativeSeedMeansItsTwosComplementPattern) {
  EXPECT_EQ(RandomStream(-5).Raw(), 1844333030U);
  EXPECT_EQ(RandomStream(-5).seed(), 0xfffffffbU);
}

TEST(RandomStreamTest, IntBetweenWrapsIn32Bits) {
  RandomStream stream(0);
  const int32_t low = 2147483600;
  const int32_t high = -2147483600;  // low + 96 modulo 2^32
  EXPECT_EQ(stream.Int(low, high), static_cast<int32_t>(2147483600U + 2357136044U % 96U));
}

TEST(RandomStreamTest, NOfReturnsAllWithoutADrawIfNExceedsTheirCount) {
  RandomStream stream(3);
  EXPECT_THAT(stream.NOf(std::vector<int>{4, 5}, 3), ElementsAre(4, 5));
  EXPECT_EQ(stream.draws(), 0U);
}

TEST(RandomStreamTest, DistinctRedrawsRepeatedValues) {
  RandomStream stream(3);
  const std::vector<int32_t> values = stream.Distinct(4, 4);
  EXPECT_THAT(values, ::testing::UnorderedElementsAre(0, 1, 2, 3));
  EXPECT_GE(stream.draws(), 4U);
}

TEST(RandomStreamTest, SplitDistributesEveryUnit) {
  RandomStream stream(3);
  const std::vector<int32_t> bins = stream.Split(100, 7);
  EXPECT_EQ(bins.size(), 7U);
  EXPECT_EQ(std::accumulate(bins.begin(), bins.end(), 0), 100);
}

// A stream restored from a snapshot of `stream`.
RandomStream Restored(RandomStream& stream) {
  StateArchive saving;
  stream.VisitState(saving);
  StateArchive restoring = *StateArchive::Open(*saving.Finish());
  RandomStream restored(99);
  restored.VisitState(restoring);
  EXPECT_TRUE(restoring.Close().ok()) << restoring.status();
  return restored;
}

TEST(RandomStreamStateTest, ARestoredStreamContinuesAfterFewAndAfterManyDraws) {
  for (const int draws : {0, 5, 1 << 20, (1 << 20) + 1, 2000000}) {
    RandomStream stream(-5);
    for (int i = 0; i < draws; ++i) {
      stream.Raw();
    }
    RandomStream restored = Restored(stream);
    EXPECT_EQ(restored.seed(), stream.seed());
    EXPECT_EQ(restored.draws(), stream.draws());
    for (int i = 0; i < 2000; ++i) {
      ASSERT_EQ(restored.Raw(), stream.Raw()) << draws;
    }
  }
}

TEST(RandomStreamStateTest, AnIncompleteGeneratorIsRejected) {
  StateArchive saving;
  uint64_t seed = 1;
  uint64_t draws = uint64_t{1} << 40;
  std::vector<int32_t> words(625, 7);
  words.back() = 625;
  saving.Bits("seed", seed);
  saving.Bits("draws", draws);
  saving.Ints("generator", words, 625, 0, 1000);
  StateArchive restoring = *StateArchive::Open(*saving.Finish());
  RandomStream stream;
  stream.VisitState(restoring);
  EXPECT_EQ(restoring.status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace procgen
