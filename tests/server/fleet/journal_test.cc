#include "server/fleet/journal.h"

#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/server/fleet/journaled_pool.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class JournalTest : public testing::Test {
 protected:
  std::unique_ptr<Journal> Create() const {
    absl::StatusOr<std::unique_ptr<Journal>> journal = Journal::Create(path_, SomePool());
    EXPECT_THAT(journal, IsOk());
    return *std::move(journal);
  }
  JournaledPool Read() const {
    absl::StatusOr<JournaledPool> pool = Journal::Read(path_);
    EXPECT_THAT(pool, IsOk());
    return pool.value_or(JournaledPool());
  }
  std::string Bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void SetBytes(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }

  const TemporaryFolder folder_;
  const std::string path_ = folder_.At("pool-1");
};

TEST_F(JournalTest, APoolIsReadAsItWasWritten) {
  JournaledPool written = SomePool();
  ShardBase sampled = *written.bases[2].second;
  auto sampler = std::make_shared<v1::LevelSampler>();
  sampler->add_level_seeds(12);
  sampled.sampler = sampler;
  written.bases[2].second = std::make_shared<const ShardBase>(sampled);
  ASSERT_THAT(Journal::Create(path_, written), IsOk());

  const JournaledPool pool = Read();
  EXPECT_EQ(pool.pool.SerializeAsString(), written.pool.SerializeAsString());
  EXPECT_EQ(pool.log_begin, 7);
  EXPECT_EQ(pool.sequence_begin, 5);
  EXPECT_EQ(pool.next_sequence_number(), 7);
  ASSERT_EQ(pool.log.size(), 2);
  EXPECT_EQ(pool.log[0].request.SerializeAsString(), SomeStep(6).request.SerializeAsString());
  ASSERT_EQ(pool.log[1].states.size(), 1);
  EXPECT_EQ(pool.log[1].states[0].environment(), 3);
  EXPECT_EQ(pool.log[1].states[0].snapshot(), "a snapshot");
  ASSERT_EQ(pool.bases.size(), 2);
  const auto& [range, base] = pool.bases.at(2);
  EXPECT_EQ(range.first, 2);
  EXPECT_EQ(range.count, 2);
  EXPECT_EQ(base->number, 7);
  EXPECT_EQ(base->states, sampled.states);
  ASSERT_NE(base->sampler, nullptr);
  EXPECT_THAT(base->sampler->level_seeds(), ElementsAre(12));
  EXPECT_EQ(pool.bases.at(0).second->sampler, nullptr);
}

TEST_F(JournalTest, WhatIsAskedIsAddedAndTakenBack) {
  const auto journal = Create();
  journal->Append(SomeStep(7));
  journal->Append(SomeStep(8));
  journal->TakeBack();
  const JournaledPool pool = Read();
  ASSERT_EQ(pool.log.size(), 3);
  EXPECT_EQ(pool.log.back().request.sequence_number(), 7);
  EXPECT_EQ(pool.next_sequence_number(), 8);
}

TEST_F(JournalTest, TheLatestBasesAreRead) {
  const auto journal = Create();
  journal->Append(SomeStep(7));
  journal->SetBase({2, 2}, SomeBase(9, "later"));
  EXPECT_EQ(Read().bases.at(2).second->number, 9);
  EXPECT_EQ(Read().bases.at(0).second->number, 7);
  journal->SetBases({{0, {{0, 4}, SomeBase(10, "whole")}}});
  const JournaledPool pool = Read();
  ASSERT_EQ(pool.bases.size(), 1);
  EXPECT_EQ(pool.bases.at(0).first.count, 4);
}

TEST_F(JournalTest, WhatNoBaseNeedsIsForgottenWhenTheFileHasGrown) {
  const auto journal = Create();
  ShardBase large = *SomeBase(9, "large");
  large.states[0].assign(size_t{9} << 20, 'x');
  journal->Append(SomeStep(7));
  journal->SetBase({2, 2}, SomeBase(9, "right"));
  journal->SetBase({0, 2}, std::make_shared<const ShardBase>(large));
  large.number = 10;
  journal->SetBase({0, 2}, std::make_shared<const ShardBase>(large));
  EXPECT_LT(Bytes().size(), size_t{10} << 20) << "it was not written anew";
  const JournaledPool pool = Read();
  EXPECT_EQ(pool.log_begin, 9);
  EXPECT_EQ(pool.sequence_begin, 6);
  ASSERT_EQ(pool.log.size(), 1);
  EXPECT_EQ(pool.next_sequence_number(), 8);
}

TEST_F(JournalTest, ARecordThatWasCutOffIsNotRead) {
  const auto journal = Create();
  const size_t before = Bytes().size();
  journal->Append(SomeStep(7));
  const std::string whole = Bytes();
  ASSERT_EQ(Read().next_sequence_number(), 8);
  for (size_t size = before; size < whole.size(); ++size) {
    SetBytes(whole.substr(0, size));
    EXPECT_EQ(Read().next_sequence_number(), 7) << size << " bytes";
  }
}

TEST_F(JournalTest, AByteThatChangedIsFoundWhereverItIs) {
  Create();
  const std::string whole = Bytes();
  for (size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    SetBytes(damaged);
    EXPECT_THAT(Journal::Read(path_).status(), testing::Not(IsOk())) << "byte " << at;
  }
  std::string damaged = whole;
  damaged.back() = static_cast<char>(damaged.back() ^ 1);
  SetBytes(damaged);
  EXPECT_THAT(Journal::Read(path_),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("pool-1 is damaged at byte ")));
}

TEST_F(JournalTest, AnotherVersionIsNamed) {
  Create();
  SetBytes(absl::StrReplaceAll(Bytes(), {{"procgen-pool 1\n", "procgen-pool 2\n"}}));
  EXPECT_THAT(Journal::Read(path_),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("pool-1 is a journal of version '2', allowed: 1;")));
}

TEST_F(JournalTest, WhatIsNoJournalIsTold) {
  EXPECT_THAT(Journal::Read(path_), StatusIs(absl::StatusCode::kNotFound, HasSubstr("pool-1")));
  for (const char* bytes : {"", "something else", "procgen-po"}) {
    SetBytes(bytes);
    EXPECT_THAT(Journal::Read(path_),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr("is no journal of a pool")));
  }
  SetBytes("procgen-pool 1\n");
  EXPECT_THAT(Journal::Read(path_),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("holds no pool")));
}

TEST_F(JournalTest, APoolThatIsRemovedStaysRemoved) {
  const auto journal = Create();
  journal->Remove();
  journal->Append(SomeStep(7));
  EXPECT_THAT(Journal::Read(path_).status(), StatusIs(absl::StatusCode::kNotFound, testing::_));
}

TEST_F(JournalTest, AFolderThatIsGoneIsTold) {
  EXPECT_THAT(Journal::Create(folder_.At("none/pool-1"), SomePool()),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("cannot write")));
}

}  // namespace
}  // namespace procgen
