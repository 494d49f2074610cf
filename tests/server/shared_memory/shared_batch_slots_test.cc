#include "server/shared_memory/shared_batch_slots.h"

#include <sys/mman.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class SharedBatchSlotsTest : public testing::Test {
 protected:
  const TemporaryFolder temporary_;
  const std::string path_ = temporary_.path();
  const std::unique_ptr<SharedMemoryDir> folder_ = *SharedMemoryDir::Open(path_);
};

TEST_F(SharedBatchSlotsTest, WrittenBatchesKeepTheirPlaceWhenTheSlotsGrow) {
  SharedBatchSlots slots(folder_.get(), 3, 48);
  EXPECT_TRUE(std::filesystem::is_empty(path_));
  ASSERT_THAT(slots.Grow(2), IsOk());
  slots.Rows(1, 2, 1).observations[0] = 77;
  const std::string path = slots.path();
  ASSERT_THAT(slots.Grow(5), IsOk());
  ASSERT_THAT(slots.Grow(4), IsOk());
  EXPECT_EQ(slots.batch_count(), 5);
  EXPECT_EQ(slots.path(), path);
  EXPECT_EQ(std::filesystem::file_size(path), static_cast<uintmax_t>(slots.size_bytes()));
  EXPECT_EQ(slots.Rows(1, 2, 1).observations[0], 77);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  const auto& arrays = slots.layout().arrays();
  ASSERT_EQ(arrays.front().field, "observations");
  const int64_t offset = slots.layout().batch_bytes() + arrays.front().offset_bytes + 2 * 48;
  EXPECT_EQ(bytes[static_cast<size_t>(offset)], 77);
}

TEST_F(SharedBatchSlotsTest, TruncatedFileIsAnErrorNotACrash) {
  SharedBatchSlots cut(folder_.get(), 3, 4096);
  SharedBatchSlots other(folder_.get(), 3, 4096);
  ASSERT_THAT(cut.Grow(2), IsOk());
  ASSERT_THAT(other.Grow(2), IsOk());
  other.Rows(1, 2, 1).observations[0] = 77;
  std::filesystem::resize_file(cut.path(), 0);
  cut.Rows(1, 0, 3).observations[0] = 5;
  EXPECT_EQ(cut.Rows(1, 0, 3).observations[0], 5);
  cut.Rows(0, 2, 1).observations[4095] = 6;
  EXPECT_EQ(cut.Rows(0, 2, 1).observations[4095], 6);
  EXPECT_EQ(other.Rows(1, 2, 1).observations[0], 77);
  EXPECT_THAT(other.Grow(3), IsOk());
  EXPECT_THAT(cut.Grow(2), StatusIs(absl::StatusCode::kFailedPrecondition,
                                    AllOf(HasSubstr("has truncated"), HasSubstr(cut.path()))));
}

TEST_F(SharedBatchSlotsTest, OtherBusErrorsStillEndTheProcess) {
  SharedBatchSlots slots(folder_.get(), 1, 4096);
  ASSERT_THAT(slots.Grow(1), IsOk());
  const auto file = folder_->MakeFile();
  ASSERT_THAT(file, IsOk());
  auto* const page = static_cast<volatile uint8_t*>(
      mmap(nullptr, 4096, PROT_READ, MAP_SHARED, (*file)->descriptor(), 0));
  EXPECT_DEATH(static_cast<void>(*page), "");
}

TEST_F(SharedBatchSlotsTest, SlotsRemoveTheirFile) {
  { SharedBatchSlots never_used(folder_.get(), 3, 48); }
  {
    SharedBatchSlots slots(folder_.get(), 3, 48);
    ASSERT_THAT(slots.Grow(1), IsOk());
    EXPECT_FALSE(std::filesystem::is_empty(path_));
  }
  EXPECT_TRUE(std::filesystem::is_empty(path_));
}

TEST_F(SharedBatchSlotsTest, FullDiskErrorNamesPathAndSizeAndChangesNothing) {
  SharedBatchSlots slots(folder_.get(), 3, 48);
  ASSERT_THAT(slots.Grow(1), IsOk());
  slots.Rows(0, 0, 1).observations[0] = 9;
  rlimit before = {};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto signal_before = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small = {static_cast<rlim_t>(3 * slots.layout().batch_bytes()), before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const absl::Status status = slots.Grow(4);
  SharedBatchSlots other(folder_.get(), 3, 48);
  const absl::Status other_status = other.Grow(4);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, signal_before);
  const std::string bytes = std::to_string(4 * slots.layout().batch_bytes()) + " bytes";
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted,
                               AllOf(HasSubstr(slots.path()), HasSubstr(bytes))));
  EXPECT_THAT(other_status, StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr(bytes)));
  EXPECT_EQ(other.batch_count(), 0);
  EXPECT_EQ(slots.batch_count(), 1);
  EXPECT_EQ(slots.Rows(0, 0, 1).observations[0], 9);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path_),
                          std::filesystem::directory_iterator()),
            1);
  EXPECT_THAT(slots.Grow(4), IsOk());
}

}  // namespace
}  // namespace procgen
