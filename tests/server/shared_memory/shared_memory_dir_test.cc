#include "server/shared_memory/shared_memory_dir.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class SharedMemoryDirTest : public testing::Test {
 protected:
  ptrdiff_t FileCount() const {
    return std::distance(std::filesystem::directory_iterator(path_),
                         std::filesystem::directory_iterator());
  }

  const TemporaryFolder temporary_;
  const std::string path_ = temporary_.path();
};

TEST_F(SharedMemoryDirTest, FilesArePrivateAndRemovedWithTheirOwner) {
  const auto folder = SharedMemoryDir::Open(path_);
  ASSERT_THAT(folder, IsOk());
  auto file = (*folder)->MakeFile();
  auto other = (*folder)->MakeFile();
  ASSERT_THAT(file, IsOk());
  ASSERT_THAT(other, IsOk());
  EXPECT_NE((*file)->path(), (*other)->path());
  struct stat facts = {};
  ASSERT_EQ(stat((*file)->path().c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0600);
  file->reset();
  other->reset();
  EXPECT_EQ(FileCount(), 0);
}

TEST_F(SharedMemoryDirTest, FilesOfRunningProcessesAreKept) {
  const auto folder = SharedMemoryDir::Open(path_);
  ASSERT_THAT(folder, IsOk());
  const auto file = (*folder)->MakeFile();
  ASSERT_THAT(file, IsOk());
  const auto second = SharedMemoryDir::Open(path_);
  ASSERT_THAT(second, IsOk());
  EXPECT_EQ((*second)->stale_file_count(), 0);
  EXPECT_TRUE(std::filesystem::exists((*file)->path()));
}

TEST_F(SharedMemoryDirTest, FilesOfKilledProcessesAreRemoved) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t process = fork();
  if (process == 0) {
    const auto folder = SharedMemoryDir::Open(path_);
    const auto file = (*folder)->MakeFile();
    const char made = file.ok() ? 'y' : 'n';
    if (write(ends[1], &made, 1) == 1) {
      pause();
    }
    _exit(1);
  }
  char made = 0;
  ASSERT_EQ(read(ends[0], &made, 1), 1);
  ASSERT_EQ(made, 'y');
  ASSERT_EQ(kill(process, SIGKILL), 0);
  ASSERT_EQ(waitpid(process, nullptr, 0), process);
  ASSERT_EQ(FileCount(), 1);
  const auto folder = SharedMemoryDir::Open(path_);
  ASSERT_THAT(folder, IsOk());
  EXPECT_EQ((*folder)->stale_file_count(), 1);
  EXPECT_EQ(FileCount(), 0);
  close(ends[0]);
  close(ends[1]);
}

TEST_F(SharedMemoryDirTest, ForeignFilesAreKept) {
  for (const char* name : {"procgen-server-1", "procgen-server-000000000000000g", "sem.x",
                           "procgen-server-00000000000000000"}) {
    std::ofstream(path_ + "/" + name) << "x";
  }
  std::filesystem::create_directory(path_ + "/procgen-server-0000000000000001");
  std::filesystem::create_symlink("sem.x", path_ + "/procgen-server-0000000000000002");
  const ptrdiff_t before = FileCount();
  const auto folder = SharedMemoryDir::Open(path_);
  ASSERT_THAT(folder, IsOk());
  EXPECT_EQ((*folder)->stale_file_count(), 0);
  EXPECT_EQ(FileCount(), before);
}

TEST_F(SharedMemoryDirTest, NonFolderIsRejected) {
  std::ofstream(path_ + "/file") << "x";
  EXPECT_THAT(SharedMemoryDir::Open(path_ + "/none"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/none")));
  EXPECT_THAT(SharedMemoryDir::Open(path_ + "/file"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("directory")));
}

TEST_F(SharedMemoryDirTest, UnwritableFolderIsRejectedAtOpen) {
  EXPECT_THAT(SharedMemoryDir::Open("/proc"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("a folder to make files in")));
}

TEST_F(SharedMemoryDirTest, RemovedFolderIsReported) {
  const auto folder = SharedMemoryDir::Open(path_);
  ASSERT_THAT(folder, IsOk());
  std::filesystem::remove_all(path_);
  EXPECT_THAT((*folder)->MakeFile(),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("/procgen-server-")));
}

}  // namespace
}  // namespace procgen
