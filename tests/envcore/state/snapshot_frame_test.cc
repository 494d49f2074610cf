#include "envcore/state/snapshot_frame.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::_;
using ::testing::HasSubstr;

TEST(SnapshotFrameTest, TheHeaderIsMagicVersionLengthAndChecksum) {
  // 0xcbf43926 is the published CRC-32 of these nine digits.
  EXPECT_EQ(
      FrameSnapshot("123456789"),
      absl::StrCat(absl::string_view("PGST\x01\x00\x00\x00\x09\x00\x00\x00\x26\x39\xf4\xcb", 16),
                   "123456789"));
}

TEST(SnapshotFrameTest, EveryTruncatedSnapshotIsDataLoss) {
  const std::string snapshot = FrameSnapshot("the body of it");
  for (size_t length = 0; length < snapshot.size(); ++length) {
    EXPECT_THAT(UnframeSnapshot(snapshot.substr(0, length)),
                StatusIs(absl::StatusCode::kDataLoss, _))
        << length;
  }
}

TEST(SnapshotFrameTest, EveryFlippedBitIsDetected) {
  const std::string snapshot = FrameSnapshot("the body of it");
  for (size_t bit = 0; bit < 8 * snapshot.size(); ++bit) {
    std::string flipped = snapshot;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_THAT(UnframeSnapshot(flipped), StatusIs(absl::StatusCode::kDataLoss, _)) << bit;
  }
}

TEST(SnapshotFrameTest, OtherVersionsAreNamed) {
  std::string snapshot = FrameSnapshot("body");
  snapshot[4] = 9;
  EXPECT_THAT(UnframeSnapshot(snapshot),
              StatusIs(absl::StatusCode::kDataLoss,
                       "the snapshot is of version 9, this engine supports version 1"));
}

TEST(SnapshotFrameTest, TooLongSnapshotsAreRejected) {
  EXPECT_THAT(UnframeSnapshot(std::string(kSnapshotBytesMax + 1, 'P')),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("must have at most 1048576")));
}

}  // namespace
}  // namespace procgen
