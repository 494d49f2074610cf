#include "tests/fuzz/snapshot_mutation.h"

#include <set>
#include <string>

#include "envcore/environment/environment.h"
#include "envcore/state/snapshot_frame.h"
#include "envcore/state/snapshot_tree.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr uint32_t kSeedCount = 300;

std::string MinerSnapshot() {
  Environment environment(*FindGame("miner"), *ResolveOptions("miner", {}), 1,
                          AutoresetMode::kSameStep);
  return environment.SaveState().value();
}

TEST(SnapshotMutationTest, MutantsAreValidSnapshotsAndMostlyDistinct) {
  const std::string snapshot = MinerSnapshot();
  std::set<std::string> mutants;
  for (uint32_t seed = 0; seed < kSeedCount; ++seed) {
    const std::string mutant = MutatedSnapshot(snapshot, seed, kSnapshotBytesMax);
    ASSERT_THAT(ParseSnapshot(mutant), IsOk());
    mutants.insert(mutant);
  }
  EXPECT_GT(mutants.size(), kSeedCount * 9 / 10);
}

TEST(SnapshotMutationTest, SomeMutantsAreRestoredAndSomeRejected) {
  const std::string snapshot = MinerSnapshot();
  uint32_t restored = 0;
  for (uint32_t seed = 0; seed < kSeedCount; ++seed) {
    const std::string mutant = MutatedSnapshot(snapshot, seed, kSnapshotBytesMax);
    restored +=
        Environment::Restore(*FindGame("miner"), mutant, AutoresetMode::kSameStep).ok() ? 1 : 0;
  }
  EXPECT_GT(restored, kSeedCount / 10);
  EXPECT_LT(restored, kSeedCount);
}

TEST(SnapshotMutationTest, EqualSeedsMakeEqualMutants) {
  const std::string snapshot = MinerSnapshot();
  EXPECT_EQ(MutatedSnapshot(snapshot, 3, kSnapshotBytesMax),
            MutatedSnapshot(snapshot, 3, kSnapshotBytesMax));
}

TEST(SnapshotMutationTest, MutantsStayWithinTheSizeLimit) {
  const std::string snapshot = MinerSnapshot();
  for (uint32_t seed = 0; seed < kSeedCount; ++seed) {
    EXPECT_LE(MutatedSnapshot(snapshot, seed, snapshot.size()).size(), snapshot.size());
  }
}

TEST(SnapshotMutationTest, InvalidSnapshotsHaveNoMutants) {
  EXPECT_EQ(MutatedSnapshot("", 1, kSnapshotBytesMax), "");
  EXPECT_EQ(MutatedSnapshot(FrameSnapshot("\xff"), 1, kSnapshotBytesMax), "");
}

}  // namespace
}  // namespace procgen
