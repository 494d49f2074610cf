// Truncated and changed journals: each reads as an earlier state of the pool, or is rejected.

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/fleet/log/journal.h"
#include "tests/server/fleet/journaled_pool.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::HasSubstr;

// Page sizes in the database file, and in the write-ahead log after its header of 32 bytes.
constexpr size_t kPageBytes = 4096;
constexpr size_t kFrameBytes = kPageBytes + 24;
constexpr size_t kLogHeadBytes = 32;

std::string BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// All contents of a pool, as text.
std::string TextOf(const JournaledPool& pool) {
  std::string text = pool.pool.ShortDebugString();
  for (const auto& [first, checkpoint] : pool.checkpoints) {
    text += "\n" + std::to_string(first) + " " + std::to_string(checkpoint.first.count) + " " +
            std::to_string(checkpoint.second->number);
    for (const std::string& state : checkpoint.second->states) {
      text += " " + state;
    }
  }
  for (const RequestLog::Entry& entry : pool.log) {
    text += "\n" + entry->request.ShortDebugString();
    for (const v1::State& state : entry->states) {
      text += " " + state.ShortDebugString();
    }
  }
  return text;
}

class JournalDamageTest : public testing::Test {
 protected:
  absl::StatusOr<JournaledPool> Read(const std::string& file, const std::string& log = "") const {
    const std::string path = folder_.At("copy");
    std::ofstream(path, std::ios::binary) << file;
    std::ofstream(path + "-wal", std::ios::binary) << log;
    return Journal::Read(path);
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_.At("pool-1");
  Metrics metrics_ = Metrics("1");
};

TEST_F(JournalDamageTest, PowerCutLeavesAnEarlierCommit) {
  const auto journal = Journal::Create(path_, SomePool(), &metrics_);
  ASSERT_THAT(journal, IsOk());
  const std::string file = BytesOf(path_);
  std::vector<std::string> moments = {TextOf(Read(file).value())};
  ASSERT_EQ(BytesOf(path_ + "-wal"), "") << "creation is synced";
  const auto add_moment = [&] {
    const auto pool = Read(file, BytesOf(path_ + "-wal"));
    ASSERT_THAT(pool, IsOk());
    moments.push_back(TextOf(*pool));
  };
  for (int64_t i = 7; i < 12; ++i) {
    (*journal)->Append(EntryOf(SomeStep(i)));
    add_moment();
  }
  (*journal)->RemoveLast();
  add_moment();
  (*journal)->SetCheckpoint({0, 2}, SomeCheckpoint(10, "left"));
  add_moment();
  (*journal)->SetCheckpoint({2, 2}, SomeCheckpoint(11, "right"));
  add_moment();
  const std::string log = BytesOf(path_ + "-wal");
  for (size_t size = 0; size <= log.size(); ++size) {
    const size_t in_frame = (size + kFrameBytes - kLogHeadBytes) % kFrameBytes;
    if (size > kLogHeadBytes && in_frame > 1 && in_frame < kFrameBytes - 1 && size % 512 != 0) {
      continue;
    }
    const auto pool = Read(file, log.substr(0, size));
    ASSERT_THAT(pool, IsOk()) << size << " of " << log.size() << " bytes";
    EXPECT_THAT(moments, testing::Contains(TextOf(*pool))) << size << " bytes";
  }
}

TEST_F(JournalDamageTest, TruncatedFileIsRejected) {
  ASSERT_THAT(Journal::Create(path_, SomePool(), &metrics_), IsOk());
  const std::string whole = BytesOf(path_);
  ASSERT_EQ(whole.size() % kPageBytes, 0);
  for (size_t size = 0; size < whole.size(); size += size % kPageBytes == 0 ? 1 : 63) {
    EXPECT_THAT(Read(whole.substr(0, size)).status(),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr("copy ")))
        << size << " of " << whole.size() << " bytes";
  }
}

TEST_F(JournalDamageTest, ChangedByteIsDetectedOrHarmless) {
  ASSERT_THAT(Journal::Create(path_, SomePool(), &metrics_), IsOk());
  const std::string whole = BytesOf(path_);
  const std::string expected = TextOf(Journal::Read(path_).value());
  int found = 0;
  for (size_t at = 0; at < whole.size(); ++at) {
    if (whole[at] == 0 && at % 64 != 0) {
      continue;  // mostly unused bytes between rows
    }
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    const auto pool = Read(damaged);
    found += pool.ok() ? 0 : 1;
    if (pool.ok()) {
      EXPECT_EQ(TextOf(*pool), expected) << "byte " << at;
    }
  }
  EXPECT_GT(found, 500);
}

TEST_F(JournalDamageTest, AnotherVersionIsNamed) {
  ASSERT_THAT(Journal::Create(path_, SomePool(), &metrics_), IsOk());
  std::string other = BytesOf(path_);
  other[63] = 3;  // SQLite's user_version
  EXPECT_THAT(Read(other), StatusIs(absl::StatusCode::kFailedPrecondition,
                                    HasSubstr("copy is a journal of version 3, allowed: 2;")));
  EXPECT_THAT(Read("procgen-pool 1\nas it was before databases"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("copy is a journal of version 1, allowed: 2;")));
}

TEST_F(JournalDamageTest, NonJournalIsReported) {
  for (const char* bytes : {"", "something else", "procgen-pool 1"}) {
    EXPECT_THAT(Read(bytes), StatusIs(absl::StatusCode::kDataLoss, HasSubstr("copy is damaged: ")))
        << bytes;
  }
}

}  // namespace
}  // namespace procgen
