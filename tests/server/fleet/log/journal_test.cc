#include "server/fleet/log/journal.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "absl/time/time.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/logging/event_log.h"
#include "tests/server/fleet/full_disk.h"
#include "tests/server/fleet/journaled_pool.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class JournalTest : public testing::Test {
 protected:
  std::unique_ptr<Journal> Create() {
    absl::StatusOr<std::unique_ptr<Journal>> journal =
        Journal::Create(path_, SomePool(), &metrics_);
    EXPECT_THAT(journal, IsOk());
    return *std::move(journal);
  }
  // The pool that the next process would read if this one was killed now.
  JournaledPool Read() const {
    const std::string copy = folder_.At("copy");
    const auto replace = std::filesystem::copy_options::overwrite_existing;
    std::filesystem::copy_file(path_, copy, replace);
    std::filesystem::copy_file(path_ + "-wal", copy + "-wal", replace);
    absl::StatusOr<JournaledPool> pool = Journal::Read(copy);
    EXPECT_THAT(pool, IsOk());
    return pool.value_or(JournaledPool());
  }
  std::string NotDurable() const {
    const std::string text = metrics_.Text();
    return text.substr(text.find("\nprocgen_fleet_pools_not_durable ") + 1, 33);
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_.At("pool-1");
  Metrics metrics_ = Metrics("1");
};

TEST_F(JournalTest, PoolRoundTrips) {
  JournaledPool written = SomePool();
  ShardCheckpoint sampled = *written.checkpoints[2].second;
  auto sampler = std::make_shared<v1::LevelSampler>();
  sampler->add_level_seeds(12);
  sampled.sampler = sampler;
  written.checkpoints[2].second = std::make_shared<const ShardCheckpoint>(sampled);
  ASSERT_THAT(Journal::Create(path_, written, &metrics_), IsOk());

  const JournaledPool pool = Read();
  EXPECT_EQ(pool.pool.SerializeAsString(), written.pool.SerializeAsString());
  EXPECT_EQ(pool.log_begin, 7);
  EXPECT_EQ(pool.sequence_begin, 5);
  EXPECT_EQ(pool.next_sequence_number(), 7);
  ASSERT_EQ(pool.log.size(), 2);
  EXPECT_EQ(pool.log[0]->request.SerializeAsString(), SomeStep(6).request.SerializeAsString());
  ASSERT_EQ(pool.log[1]->states.size(), 1);
  EXPECT_EQ(pool.log[1]->states[0].environment(), 3);
  EXPECT_EQ(pool.log[1]->states[0].snapshot(), "a snapshot");
  ASSERT_EQ(pool.checkpoints.size(), 2);
  const auto& [range, checkpoint] = pool.checkpoints.at(2);
  EXPECT_EQ(range.first, 2);
  EXPECT_EQ(range.count, 2);
  EXPECT_EQ(checkpoint->number, 7);
  EXPECT_EQ(checkpoint->states, sampled.states);
  ASSERT_NE(checkpoint->sampler, nullptr);
  EXPECT_THAT(checkpoint->sampler->level_seeds(), ElementsAre(12));
  EXPECT_EQ(pool.checkpoints.at(0).second->sampler, nullptr);
}

TEST_F(JournalTest, RequestsAreAddedAndRemoved) {
  const auto journal = Create();
  journal->Append(EntryOf(SomeStep(7)));
  journal->Append(EntryOf(SomeStep(8)));
  EXPECT_EQ(Read().next_sequence_number(), 9);
  journal->RemoveLast();
  EXPECT_EQ(Read().next_sequence_number(), 8);
  journal->Append(EntryOf(SomeStates(2)));
  const JournaledPool pool = Read();
  ASSERT_EQ(pool.log.size(), 4);
  EXPECT_EQ(pool.log[2]->request.sequence_number(), 7);
  EXPECT_EQ(pool.log[3]->states.size(), 1);
}

TEST_F(JournalTest, TheLatestCheckpointsAreRead) {
  const auto journal = Create();
  journal->Append(EntryOf(SomeStep(7)));
  journal->SetCheckpoint({2, 2}, SomeCheckpoint(9, "later"));
  EXPECT_EQ(Read().checkpoints.at(2).second->number, 9);
  EXPECT_EQ(Read().checkpoints.at(0).second->number, 7);
  ShardCheckpoint whole = *SomeCheckpoint(10, "whole");
  whole.states.resize(4);
  journal->SetCheckpoints({{0, {{0, 4}, std::make_shared<const ShardCheckpoint>(whole)}}});
  const JournaledPool pool = Read();
  ASSERT_EQ(pool.checkpoints.size(), 1);
  EXPECT_EQ(pool.checkpoints.at(0).first.count, 4);
}

TEST_F(JournalTest, EntriesBeforeAllCheckpointsAreDropped) {
  const auto journal = Create();
  journal->Append(EntryOf(SomeStep(7)));
  journal->SetCheckpoint({2, 2}, SomeCheckpoint(9, "right"));
  EXPECT_EQ(Read().log_begin, 7);
  journal->SetCheckpoint({0, 2}, SomeCheckpoint(10, "left"));
  JournaledPool pool = Read();
  EXPECT_EQ(pool.log_begin, 9);
  EXPECT_EQ(pool.sequence_begin, 6);
  ASSERT_EQ(pool.log.size(), 1);
  EXPECT_EQ(pool.next_sequence_number(), 8);
  journal->SetCheckpoint({2, 2}, SomeCheckpoint(10, "right"));
  pool = Read();
  EXPECT_EQ(pool.log.size(), 0);
  EXPECT_EQ(pool.next_sequence_number(), 8);
}

TEST_F(JournalTest, TheFileDoesNotGrowWithTheNumberOfRequests) {
  const auto journal = Create();
  ShardCheckpoint checkpoint = *SomeCheckpoint(9, "");
  checkpoint.states[0].assign(size_t{1} << 20, 'x');
  for (int i = 0; i < 100; ++i) {
    journal->Append(EntryOf(SomeStep(7 + i)));
    ++checkpoint.number;
    journal->SetCheckpoint({0, 2}, std::make_shared<const ShardCheckpoint>(checkpoint));
    journal->SetCheckpoint({2, 2}, SomeCheckpoint(checkpoint.number, "right"));
  }
  EXPECT_LT(std::filesystem::file_size(path_), size_t{4} << 20);
  EXPECT_LT(std::filesystem::file_size(path_ + "-wal"), size_t{20} << 20);
}

TEST_F(JournalTest, ResumedPoolContinues) {
  Create();
  const auto journal = Journal::Resume(path_, Journal::Read(path_).value(), &metrics_);
  journal->Append(EntryOf(SomeStep(7)));
  journal->SetCheckpoint({0, 2}, SomeCheckpoint(10, "left"));
  const JournaledPool pool = Read();
  EXPECT_EQ(pool.next_sequence_number(), 8);
  EXPECT_EQ(pool.log.size(), 3);
  EXPECT_EQ(pool.checkpoints.at(0).second->number, 10);
}

TEST_F(JournalTest, FullDiskLosesNothing) {
  const auto journal = Create();
  journal->Append(EntryOf(SomeStep(7)));
  testing::internal::CaptureStderr();
  {
    const FullDisk full(1024);  // enough for the log
    journal->Append(EntryOf(SomeStep(8)));
    journal->Append(EntryOf(SomeStep(9)));
    EXPECT_EQ(NotDurable(), "procgen_fleet_pools_not_durable 1");
    journal->RemoveLast();
    journal->SetCheckpoint({2, 2}, SomeCheckpoint(11, "right"));
  }
  EXPECT_EQ(Read().next_sequence_number(), 8) << "the last commit";
  journal->SetCheckpoint({0, 2}, SomeCheckpoint(10, "left"));
  FlushLog(absl::Seconds(10));
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("event=journal_write_failed pool=pools/7 owner=alice message=\"cannot "
                             "use"));
  EXPECT_THAT(log, HasSubstr("event=journal_write_recovered pool=pools/7"));
  EXPECT_EQ(NotDurable(), "procgen_fleet_pools_not_durable 0");
  const JournaledPool pool = Read();
  EXPECT_EQ(pool.next_sequence_number(), 9);
  EXPECT_EQ(pool.checkpoints.at(2).second->number, 11);
  EXPECT_EQ(pool.log.size(), 1);
}

TEST_F(JournalTest, RequestsRestoreDurabilityAfterAFullDisk) {
  const auto journal = Create();
  {
    const FullDisk full;
    for (int64_t i = 7; i < 27; ++i) {
      journal->Append(EntryOf(SomeStep(i)));
    }
  }
  for (int64_t i = 27; i < 67; ++i) {
    journal->Append(EntryOf(SomeStep(i)));
  }
  EXPECT_EQ(Read().next_sequence_number(), 67);
}

TEST_F(JournalTest, RoomInTheWriteAheadLogIsUsedBeforeAWriteFails) {
  const auto journal = Create();
  ShardCheckpoint checkpoint = *SomeCheckpoint(7, "");
  checkpoint.states[0].assign(size_t{1} << 20, 'x');
  const FullDisk full(int64_t{4} << 20);
  for (int i = 0; i < 20; ++i) {
    journal->SetCheckpoint({0, 2}, std::make_shared<const ShardCheckpoint>(checkpoint));
  }
  EXPECT_EQ(NotDurable(), "procgen_fleet_pools_not_durable 0");
}

TEST_F(JournalTest, LastWriteIsRetriedAtShutdown) {
  auto journal = Create();
  {
    const FullDisk full;
    journal->Append(EntryOf(SomeStep(7)));
  }
  journal = nullptr;
  EXPECT_EQ(Read().next_sequence_number(), 8);
}

TEST_F(JournalTest, FailedCreationLeavesNoFile) {
  const FullDisk full;
  EXPECT_THAT(Journal::Create(path_, SomePool(), &metrics_),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("cannot use ")));
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(JournalTest, ExistingFileIsNotReplaced) {
  Create();
  EXPECT_THAT(Journal::Create(path_, SomePool("pools/8"), &metrics_),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("exists already")));
  EXPECT_EQ(Read().pool.name(), "pools/7");
}

TEST_F(JournalTest, RemovedPoolStaysRemoved) {
  const auto journal = Create();
  journal->Remove();
  journal->Append(EntryOf(SomeStep(7)));
  EXPECT_THAT(Journal::Read(path_).status(), StatusIs(absl::StatusCode::kUnavailable, testing::_));
  EXPECT_FALSE(std::filesystem::exists(path_ + "-wal"));
}

TEST_F(JournalTest, RemovedFolderIsReported) {
  EXPECT_THAT(Journal::Create(folder_.At("none/pool-1"), SomePool(), &metrics_),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("none/pool-1")));
}

}  // namespace
}  // namespace procgen
