#include "server/fleet/log/fleet_state.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/logging/event_log.h"
#include "tests/server/fleet/journaled_pool.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> NamesOf(const std::vector<FleetState::Left>& left) {
  std::vector<std::string> names;
  names.reserve(left.size());
  for (const FleetState::Left& each : left) {
    names.push_back(each.pool.pool.name());
  }
  return names;
}

TEST(FleetStateTest, DamagedPoolIsQuarantinedAndOthersAreLoaded) {
  const TemporaryFolder folder;
  Metrics metrics("1");
  {
    const auto state = FleetState::Open(folder.path());
    ASSERT_THAT(state, IsOk());
    for (const char* name : {"pools/a", "pools/b", "pools/c"}) {
      ASSERT_THAT(Journal::Create((*state)->NextPath(), SomePool(name), &metrics), IsOk());
    }
  }
  std::ofstream(folder.At("pool-2"), std::ios::binary) << "the quarantined file";
  std::ofstream(folder.At("pool-2-wal"), std::ios::binary) << "the write-ahead log";
  const auto state = FleetState::Open(folder.path());
  ASSERT_THAT(state, IsOk());
  testing::internal::CaptureStderr();
  EXPECT_THAT(NamesOf((*state)->TakeLeft()), ElementsAre("pools/a", "pools/c"));
  FlushLog(absl::Seconds(10));
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("journal_quarantined"));
  EXPECT_THAT(log, HasSubstr("pool-2 is damaged: file is not a database"));
  EXPECT_TRUE(std::filesystem::exists(folder.At("pool-2.damaged")));
  EXPECT_TRUE(std::filesystem::exists(folder.At("pool-2.damaged-wal")));
  EXPECT_EQ((*state)->NextPath(), folder.At("pool-4"));
}

TEST(FleetStateTest, NumberOfADamagedPoolIsNotReused) {
  const TemporaryFolder folder;
  std::ofstream(folder.At("pool-3.damaged")) << "from an earlier start";
  std::ofstream(folder.At("pool-x")) << "not a pool's file";
  const auto state = FleetState::Open(folder.path());
  ASSERT_THAT(state, IsOk());
  EXPECT_THAT((*state)->TakeLeft(), testing::IsEmpty());
  EXPECT_EQ((*state)->NextPath(), folder.At("pool-4"));
}

TEST(FleetStateTest, TruncatedTextJournalIsQuarantined) {
  for (const char* text : {"", "procgen-pool ", "procgen-pool 1"}) {
    const TemporaryFolder folder;
    std::ofstream(folder.At("pool-1")) << text;
    const auto state = FleetState::Open(folder.path());
    ASSERT_THAT(state, IsOk());
    EXPECT_THAT((*state)->TakeLeft(), testing::IsEmpty());
    EXPECT_TRUE(std::filesystem::exists(folder.At("pool-1.damaged"))) << '"' << text << '"';
  }
}

TEST(FleetStateTest, PoolOfAnotherVersionIsKept) {
  const TemporaryFolder folder;
  std::ofstream(folder.At("pool-7")) << "procgen-pool 1\n";
  const auto state = FleetState::Open(folder.path());
  ASSERT_THAT(state, IsOk());
  testing::internal::CaptureStderr();
  EXPECT_THAT((*state)->TakeLeft(), testing::IsEmpty());
  FlushLog(absl::Seconds(10));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("is a journal of version"));
  EXPECT_TRUE(std::filesystem::exists(folder.At("pool-7")));
  EXPECT_EQ((*state)->NextPath(), folder.At("pool-8")) << "overwrites nothing";
}

TEST(FleetStateTest, FleetNameIsPersistent) {
  const TemporaryFolder folder;
  const std::string name = (*FleetState::Open(folder.path()))->fleet_name();
  EXPECT_FALSE(name.empty());
  EXPECT_EQ((*FleetState::Open(folder.path()))->fleet_name(), name);
}

TEST(FleetStateTest, FolderIsLockedByOneProcess) {
  const TemporaryFolder folder;
  const auto state = FleetState::Open(folder.path());
  ASSERT_THAT(state, IsOk());
  EXPECT_THAT(FleetState::Open(folder.path()), StatusIs(absl::StatusCode::kFailedPrecondition,
                                                        HasSubstr("used by another process")));
}

TEST(FleetStateTest, FileIsRejectedAsFolder) {
  const TemporaryFolder folder;
  std::ofstream(folder.At("file")) << "x";
  EXPECT_THAT(FleetState::Open(folder.At("file")),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("cannot create a file")));
}

}  // namespace
}  // namespace procgen
