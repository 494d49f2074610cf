#include "server/shared_memory/shared_layout.h"

#include <set>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(SharedLayoutTest, ArraysAreAlignedAndBatchesWholePages) {
  for (const int32_t env_count : {1, 3, 64, 341}) {
    const SharedLayout layout(env_count, 12288);
    std::set<absl::string_view> fields;
    for (const SharedArray& array : layout.arrays()) {
      EXPECT_EQ(array.offset_bytes % 64, 0) << array.field;
      EXPECT_LT(array.offset_bytes, layout.batch_bytes());
      EXPECT_TRUE(fields.insert(array.field).second) << array.field;
    }
    EXPECT_EQ(fields.size(), 12U);
    EXPECT_EQ(layout.batch_bytes() % 4096, 0);
  }
}

// Writes each row of each array; expects that no byte is written twice.
TEST(SharedLayoutTest, RowsOfSlicesAreDisjointAndInBounds) {
  constexpr int32_t kEnvCount = 5;
  constexpr int64_t kObservationBytes = 48;
  const SharedLayout layout(kEnvCount, kObservationBytes);
  std::vector<uint8_t> memory(static_cast<size_t>(layout.batch_bytes()), 0);
  int64_t written = 0;
  const auto write = [&](auto span) {
    auto* bytes = reinterpret_cast<uint8_t*>(span.data());
    const size_t size = span.size() * sizeof(span[0]);
    ASSERT_GE(bytes, memory.data());
    ASSERT_LE(bytes + size, memory.data() + memory.size());
    for (size_t i = 0; i < size; ++i) {
      ++bytes[i];
      ++written;
    }
  };
  for (const auto& [first, count] : {std::pair(0, 2), std::pair(2, 3)}) {
    const Batch rows = layout.Rows(memory.data(), first, count);
    write(rows.observations);
    write(rows.final_observations);
    write(rows.fingerprints);
    write(rows.rewards);
    write(rows.episode_returns);
    write(rows.level_seeds);
    write(rows.prev_level_seeds);
    write(rows.episode_lengths);
    write(rows.first);
    write(rows.terminated);
    write(rows.truncated);
    write(rows.prev_level_complete);
  }
  EXPECT_EQ(written, kEnvCount * (2 * kObservationBytes + 5 * 4 + 4 + 8));
  for (const uint8_t count : memory) {
    ASSERT_LE(count, 1);
  }
}

}  // namespace
}  // namespace procgen
