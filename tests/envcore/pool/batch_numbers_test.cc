#include "envcore/pool/batch_numbers.h"

#include <vector>

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(BatchNumbersTest, BuffersReplaceOnlyEmptyArrays) {
  BatchNumbers numbers;
  std::vector<uint8_t> terminated(8);
  Batch given;
  given.terminated = absl::MakeSpan(terminated);
  const Batch batch = numbers.ReplaceEmptyArrays(given, 8);
  EXPECT_EQ(batch.terminated.data(), terminated.data());
  EXPECT_EQ(batch.truncated.size(), 8);
  EXPECT_EQ(batch.rewards.size(), 8);
  EXPECT_EQ(batch.fingerprints.size(), 8);
  EXPECT_EQ(batch.rewards.data(), numbers.rewards.data());
  EXPECT_TRUE(batch.observations.empty());
  EXPECT_TRUE(batch.final_observations.empty());
}

}  // namespace
}  // namespace procgen
