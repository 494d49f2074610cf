#include "envcore/state/state_archive.h"

#include <cmath>
#include <limits>

#include "absl/functional/function_ref.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "envcore/state/snapshot_frame.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Visit = absl::FunctionRef<void(StateArchive&)>;

std::string Saved(Visit visit) {
  StateArchive archive;
  visit(archive);
  const absl::StatusOr<std::string> snapshot = archive.Finish();
  EXPECT_THAT(snapshot, IsOk());
  return snapshot.value_or("");
}

absl::Status Restored(const std::string& snapshot, Visit visit) {
  absl::StatusOr<StateArchive> archive = StateArchive::Open(snapshot);
  if (!archive.ok()) {
    return archive.status();
  }
  visit(*archive);
  return archive->Close();
}

absl::Status Invalid(const std::string& message) { return absl::InvalidArgumentError(message); }

struct Ball {
  float x = 0;
  int32_t bounces = 0;
  bool marked = false;
};

void VisitBall(StateArchive& archive, Ball& ball) {
  archive.Float("x", ball.x, -10, 10);
  archive.Int("bounces", ball.bounces, 0, 100, 0);
  archive.Bool("marked", ball.marked, false);
}

std::string SavedInt(int32_t value) {
  return Saved([&](StateArchive& archive) { archive.Int("count", value, -1000, 1000); });
}

std::string SavedFloat(float value) {
  return Saved([&](StateArchive& archive) { archive.Float("x", value, -1e9F, 1e9F); });
}

TEST(StateArchiveTest, EveryTypeIsRestored) {
  bool flag = true;
  int32_t number = -7;
  float real = 0.1F;
  uint64_t bits = 0xfedcba9876543210U;
  std::string text = "caveflyer";
  std::vector<int32_t> numbers = {3, -1, 4};
  std::vector<Ball> balls = {{.x = 1.5F, .bounces = 2, .marked = true}, {.x = -2}};
  const auto visit = [&](StateArchive& archive) {
    archive.Bool("flag", flag);
    archive.Int("number", number, -10, 10);
    archive.Group("inner", [&] {
      archive.Float("real", real, 0, 1);
      archive.Bits("bits", bits);
    });
    archive.Text("text", text, 20);
    archive.Ints("numbers", numbers, 3, -1, 9);
    archive.Groups<Ball>("balls", balls, 1, 2, [&](Ball& ball) { VisitBall(archive, ball); });
  };
  const std::string snapshot = Saved(visit);
  flag = false;
  number = 0;
  real = 0;
  bits = 0;
  text.clear();
  numbers.clear();
  balls.clear();

  ASSERT_THAT(Restored(snapshot, visit), IsOk());

  EXPECT_TRUE(flag);
  EXPECT_EQ(number, -7);
  EXPECT_EQ(real, 0.1F);
  EXPECT_EQ(bits, 0xfedcba9876543210U);
  EXPECT_EQ(text, "caveflyer");
  EXPECT_THAT(numbers, ElementsAre(3, -1, 4));
  ASSERT_EQ(balls.size(), 2);
  EXPECT_EQ(balls[0].bounces, 2);
  EXPECT_TRUE(balls[0].marked);
  EXPECT_EQ(balls[1].x, -2);
  EXPECT_EQ(balls[1].bounces, 0);
}

TEST(StateArchiveTest, FloatsAreRestoredExactly) {
  for (const float value : {-0.0F, 0.0F, std::numeric_limits<float>::denorm_min(), 1 / 3.0F,
                            std::nextafter(1.0F, 2.0F), 1e-30F, 999999.94F}) {
    float restored = 5;
    ASSERT_THAT(Restored(SavedFloat(value),
                         [&](StateArchive& archive) { archive.Float("x", restored, -1e9F, 1e9F); }),
                IsOk());
    EXPECT_EQ(restored, value);
    EXPECT_EQ(std::signbit(restored), std::signbit(value));
  }
}

TEST(StateArchiveTest, ValuesOutOfRangeAreNamedWithTheirRange) {
  int32_t count = 0;
  EXPECT_EQ(Restored(SavedInt(11), [&](StateArchive& a) { a.Int("count", count, 0, 10); }),
            Invalid("count is 11, must be in [0, 10]"));
  EXPECT_EQ(count, 0);
  float x = 0;
  EXPECT_EQ(Restored(SavedFloat(2), [&](StateArchive& a) { a.Float("x", x, -1, 1); }),
            Invalid("x is 2, must be in [-1, 1]"));
  EXPECT_EQ(x, 0);
}

TEST(StateArchiveTest, AValueOutOfRangeCannotBeSaved) {
  StateArchive archive;
  float x = std::numeric_limits<float>::quiet_NaN();
  archive.Float("x", x, -1, 1);
  EXPECT_THAT(archive.Finish(),
              StatusIs(absl::StatusCode::kInternal, "x is nan, must be in [-1, 1]"));
}

TEST(StateArchiveTest, ASaturatingArchiveClampsTheSnapshotAndTheVisitedObject) {
  int32_t below = -5;
  int32_t above = 12;
  float nan = std::numeric_limits<float>::quiet_NaN();
  float infinite = std::numeric_limits<float>::infinity();
  float inside = -0.0F;
  uint64_t bits = 9;
  const auto visit = [&](StateArchive& archive) {
    archive.Int("below", below, 0, 10);
    archive.Int("above", above, 0, 10);
    archive.Float("nan", nan, -1, 1);
    archive.Float("infinite", infinite, -1, 1);
    archive.Float("inside", inside, -1, 1);
    archive.Bits("bits", bits, 7);
  };
  StateArchive archive(StateArchive::OutOfRange::kSaturates);
  visit(archive);
  const absl::StatusOr<std::string> snapshot = archive.Finish();
  ASSERT_THAT(snapshot, IsOk());
  EXPECT_EQ(below, 0);
  EXPECT_EQ(above, 10);
  EXPECT_EQ(nan, -1);
  EXPECT_EQ(infinite, 1);
  EXPECT_TRUE(std::signbit(inside));
  EXPECT_EQ(bits, 7U);
  below = above = 3;
  ASSERT_THAT(Restored(*snapshot, visit), IsOk());
  EXPECT_EQ(below, 0);
  EXPECT_EQ(above, 10);
}

TEST(StateArchiveTest, PathsNameGroupsAndLists) {
  std::vector<Ball> balls = {{.x = 0}, {.x = 9}};
  const std::string snapshot = Saved([&](StateArchive& archive) {
    archive.Group("game", [&] {
      archive.Groups<Ball>("balls", balls, 0, 9, [&](Ball& ball) { VisitBall(archive, ball); });
    });
  });
  EXPECT_EQ(Restored(snapshot,
                     [&](StateArchive& archive) {
                       archive.Group("game", [&] {
                         archive.Groups<Ball>("balls", balls, 0, 9, [&](Ball& ball) {
                           archive.Float("x", ball.x, 0, 1);
                         });
                       });
                     }),
            Invalid("game.balls[1].x is 9, must be in [0, 1]"));
}

TEST(StateArchiveTest, MissingUnknownAndMistypedFieldsAreRejected) {
  const std::string snapshot = SavedInt(3);
  int32_t count = 0;
  bool flag = false;
  EXPECT_EQ(Restored(snapshot, [&](StateArchive& a) { a.Int("size", count, 0, 9); }),
            Invalid("size is missing"));
  EXPECT_EQ(Restored(snapshot, [&](StateArchive& a) { a.Bool("count", flag); }),
            Invalid("count is not a boolean"));
  EXPECT_EQ(Restored(snapshot, [](StateArchive& /*archive*/) {}),
            Invalid("the snapshot has the unknown field count; its fields are "));
}

TEST(StateArchiveTest, TooLongListsAreNotAllocated) {
  std::vector<int32_t> numbers(10, 1);
  const std::string snapshot =
      Saved([&](StateArchive& archive) { archive.Ints("numbers", numbers, 10, 0, 1); });
  EXPECT_EQ(Restored(snapshot, [&](StateArchive& a) { a.Ints("numbers", numbers, 9, 0, 1); }),
            Invalid("numbers has 10 entries, must have from 0 to 9"));
}

TEST(StateArchiveTest, AfterAnErrorNothingIsVisited) {
  int32_t count = 0;
  int32_t other = 5;
  const absl::Status status = Restored(SavedInt(3), [&](StateArchive& archive) {
    archive.Int("size", count, 0, 9);
    archive.Int("count", other, 0, 9);
    archive.Check(false, "is too late");
  });
  EXPECT_EQ(status, Invalid("size is missing"));
  EXPECT_EQ(other, 5);
}

TEST(StateArchiveTest, BodiesThatAreNotAGroupAreDataLoss) {
  // Empty; a number; a list; half a group; infinitely nested; 2^60 entries; a null field.
  const std::string bodies[] = {"",
                                "\x01",
                                "\x80",
                                "\xa1\x61",
                                std::string(100000, '\x81'),
                                std::string("\xa1\x61x\x9b\x10\0\0\0\0\0\0\0", 12),
                                "\xa1\x61x\xf6"};
  for (const std::string& body : bodies) {
    EXPECT_THAT(StateArchive::Open(FrameSnapshot(body)).status(),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr("not a group of fields")))
        << body.size();
  }
}

// A body with one group: its header announces `announced` fields, and `present` fields follow.
std::string GroupOfFields(uint32_t announced, uint32_t present) {
  std::string body = "\xba";
  for (int shift = 24; shift >= 0; shift -= 8) {
    body.push_back(static_cast<char>((announced >> shift) & 0xFFU));
  }
  for (uint32_t field = 0; field < present; ++field) {
    body += '\x66';  // a name of six bytes
    body += absl::StrCat(absl::Dec(field, absl::kZeroPad6), absl::string_view("\0", 1));
  }
  return body;
}

// The fields are missing: the header of the group is rejected before any field is read.
TEST(StateArchiveTest, GroupsOfTooManyFieldsAreRejectedByTheirHeader) {
  EXPECT_EQ(StateArchive::Open(FrameSnapshot(GroupOfFields(200000, 0))).status(),
            absl::DataLossError("the snapshot's body is not a group of fields in CBOR: a group has "
                                "200000 fields, at most 64 are allowed"));
  EXPECT_THAT(StateArchive::Open(FrameSnapshot("\xa1\x61x" + GroupOfFields(65, 65))).status(),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("a group has 65 fields")));
}

TEST(StateArchiveTest, BodiesThatAreTooDeepOrTooLargeAreRejectedWithTheLimit) {
  EXPECT_THAT(
      StateArchive::Open(FrameSnapshot("\xa1\x61x" + std::string(8, '\x81') + "\x01")).status(),
      StatusIs(absl::StatusCode::kDataLoss, HasSubstr("nested more than 8 deep")));
  EXPECT_THAT(StateArchive::Open(FrameSnapshot(std::string("\xa1\x61x\x9a\0\x04\0\0", 8))).status(),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("more than 250000 values")));
}

TEST(StateArchiveTest, NumbersThatPeopleWroteAreRounded) {
  const std::string limit = "\xa1\x61x\xfb\x47\xef\xff\xff\xe5\x4d\xaf\xf8";  // 3.4028235e38
  const std::string integer = "\xa1\x61x\x03";
  for (const auto& [body, expected] :
       {std::pair(limit, std::numeric_limits<float>::max()), std::pair(integer, 3.0F)}) {
    float x = 0;
    auto archive = StateArchive::Open(FrameSnapshot(body), StateArchive::Floats::kRounded);
    ASSERT_THAT(archive, IsOk());
    archive->Float("x", x, 0, std::numeric_limits<float>::max());
    EXPECT_THAT(archive->Close(), IsOk());
    EXPECT_EQ(x, expected);
    EXPECT_FALSE(Restored(FrameSnapshot(body), [&](StateArchive& exact) {
                   exact.Float("x", x, 0, std::numeric_limits<float>::max());
                 }).ok());
  }
}

}  // namespace
}  // namespace procgen
