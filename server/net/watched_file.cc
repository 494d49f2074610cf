#include "server/net/watched_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "absl/cleanup/cleanup.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

int64_t Nanoseconds(const timespec& time) {
  return int64_t{time.tv_sec} * 1'000'000'000 + int64_t{time.tv_nsec};
}

absl::StatusOr<std::string> ReadAll(int file, const std::string& path) {
  std::string bytes(WatchedFile::kBytesMax + 1, '\0');
  size_t size = 0;
  while (size < bytes.size()) {
    const ssize_t count = read(file, bytes.data() + size, bytes.size() - size);
    if (count < 0) {
      return absl::ErrnoToStatus(errno, path);
    }
    if (count == 0) {
      bytes.resize(size);
      return bytes;
    }
    size += static_cast<size_t>(count);
  }
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": has more than ", WatchedFile::kBytesMax, " bytes"));
}

}  // namespace

WatchedFile::Stamp WatchedFile::StampOf(const struct stat& file) {
  return std::tuple(uint64_t{file.st_dev}, uint64_t{file.st_ino}, int64_t{file.st_size},
                    Nanoseconds(file.st_mtim), Nanoseconds(file.st_ctim));
}

absl::StatusOr<std::string> WatchedFile::Read() {
  stamp_.reset();
  // Non-blocking, because the path may be a pipe without a writer.
  const int file = open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) {
    const int error = errno;
    // An unreadable file is not read again until it changes.
    if (struct stat status = {}; stat(path_.c_str(), &status) == 0) {
      stamp_ = StampOf(status);
    }
    return absl::ErrnoToStatus(error, path_);
  }
  const absl::Cleanup close_file = [file] { close(file); };
  struct stat status = {};
  if (fstat(file, &status) != 0) {
    return absl::ErrnoToStatus(errno, path_);
  }
  stamp_ = StampOf(status);
  is_world_readable_ = (status.st_mode & S_IROTH) != 0;
  if (!S_ISREG(status.st_mode)) {
    return absl::InvalidArgumentError(absl::StrCat(path_, ": is not a regular file"));
  }
  return ReadAll(file, path_);
}

bool WatchedFile::HasChanged() const {
  struct stat status = {};
  const bool is_there = stat(path_.c_str(), &status) == 0;
  return stamp_ != (is_there ? StampOf(status) : std::nullopt);
}

}  // namespace procgen
