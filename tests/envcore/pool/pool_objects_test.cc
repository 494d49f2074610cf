// Objects of a pool's environments, and of snapshots.

#include <cstdint>
#include <memory>
#include <vector>

#include "envcore/pool/pool.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/small_pool.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr int32_t kRows = 6;

struct Objects {
  explicit Objects(int32_t env_count)
      : rows(static_cast<size_t>(env_count * kRows)), counts(static_cast<size_t>(env_count)) {}

  std::vector<ObjectRow> rows;
  std::vector<int32_t> counts;
};

TEST(PoolObjectsTest, RowsOfASliceEqualThoseOfItsSnapshots) {
  const std::unique_ptr<Pool> pool = MadePool(OptionsOf({"maze", "starpilot"}));
  for (int step = 0; step < 40; ++step) {
    Stepped(*pool, AllTake(7));
  }
  Objects read(3);
  ASSERT_THAT(
      pool->ReadObjects(1, 3, kRows, absl::MakeSpan(read.rows), absl::MakeSpan(read.counts)),
      IsOk());
  Objects saved(3);
  ASSERT_THAT(ReadObjectsOf(pool->SaveStates({1, 2, 3}).value(), kRows, absl::MakeSpan(saved.rows),
                            absl::MakeSpan(saved.counts)),
              IsOk());
  EXPECT_EQ(read.counts, saved.counts);
  EXPECT_EQ(read.counts[1], 2);
  for (size_t i = 0; i < read.rows.size(); ++i) {
    EXPECT_EQ(read.rows[i].kind, saved.rows[i].kind) << i;
    EXPECT_EQ(read.rows[i].x, saved.rows[i].x) << i;
    EXPECT_EQ(read.rows[i].vx, saved.rows[i].vx) << i;
  }
}

TEST(PoolObjectsTest, WrongLengthsAreRejected) {
  const std::unique_ptr<Pool> pool = MazePool();
  Objects objects(kEnvCount);
  const auto read = [&](int32_t first, int32_t count, int32_t objects_max) {
    return pool->ReadObjects(first, count, objects_max, absl::MakeSpan(objects.rows),
                             absl::MakeSpan(objects.counts));
  };
  EXPECT_THAT(read(0, kEnvCount, kRows), IsOk());
  EXPECT_THAT(read(1, kEnvCount, kRows),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "the slice is 4 environments from 1 on, the pool has 4"));
  EXPECT_THAT(read(0, kEnvCount, 0), StatusIs(absl::StatusCode::kInvalidArgument,
                                              "objects_max is 0, must be in [1, 4096]"));
  EXPECT_THAT(read(0, kEnvCount, kRows - 1),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "rows has 24 and counts 4 entries, must have 20 and 4"));
}

}  // namespace
}  // namespace procgen
