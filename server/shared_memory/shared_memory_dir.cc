#include "server/shared_memory/shared_memory_dir.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <random>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"

namespace procgen {
namespace {

// Prefix of file names; a random number follows, since machines or containers may have directories
// of the same path. A client that opens the wrong directory finds no file.
constexpr absl::string_view kNamePrefix = "procgen-server-";
constexpr size_t kNumberDigits = 16;
constexpr mode_t kOwnUserOnly = 0600;
// A starting server can mistake a new file for a stale one.
constexpr int kTriesMax = 10;

bool IsOurs(absl::string_view name) {
  return absl::ConsumePrefix(&name, kNamePrefix) && name.size() == kNumberDigits &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char letter) { return absl::ascii_isxdigit(letter); });
}

std::string DrawName() {
  std::random_device device;
  const uint64_t number = (uint64_t{device()} << 32) | device();
  return absl::StrCat(kNamePrefix, absl::Hex(number, absl::kZeroPad16));
}

// Removes the file if it is stale: of this user, and not locked by a live server.
bool RemoveStaleFile(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    return false;
  }
  struct stat facts = {};
  const bool is_stale = fstat(descriptor, &facts) == 0 && S_ISREG(facts.st_mode) &&
                        facts.st_uid == geteuid() && flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  // Removed under the lock, so that its creator can detect the removal.
  const bool removed = is_stale && unlink(path.c_str()) == 0;
  close(descriptor);
  return removed;
}

int RemoveStaleFiles(const std::string& folder) {
  int count = 0;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    if (IsOurs(entry->path().filename().native()) && RemoveStaleFile(entry->path())) {
      ++count;
    }
  }
  return count;
}

// Locks a new file. Returns whether it is locked and still exists.
bool Lock(int descriptor) {
  struct stat facts = {};
  return flock(descriptor, LOCK_EX | LOCK_NB) == 0 && fstat(descriptor, &facts) == 0 &&
         facts.st_nlink > 0;
}

}  // namespace

SharedFile::~SharedFile() {
  // Before the descriptor closes and releases the lock, so that the file never looks stale.
  unlink(path_.c_str());
  close(descriptor_);
}

absl::StatusOr<std::unique_ptr<SharedMemoryDir>> SharedMemoryDir::Open(const std::string& path) {
  // Clients may have other working directories.
  std::error_code error;
  const std::string folder = std::filesystem::canonical(path, error);
  if (!error && !std::filesystem::is_directory(folder, error) && !error) {
    error = std::make_error_code(std::errc::not_a_directory);
  }
  if (!error && access(folder.c_str(), R_OK | W_OK | X_OK) != 0) {
    error = std::error_code(errno, std::generic_category());
  }
  if (error) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", path, "': ", error.message(), "; allowed: a folder to make files in"));
  }
  std::unique_ptr<SharedMemoryDir> opened(new SharedMemoryDir(folder, RemoveStaleFiles(folder)));
  // Some directories are writable but accept no files: /proc.
  if (const auto file = opened->MakeFile(); !file.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("'", path, "': ", file.status().message(),
                                                   "; allowed: a folder to make files in"));
  }
  return opened;
}

absl::StatusOr<std::unique_ptr<SharedFile>> SharedMemoryDir::MakeFile() const {
  int error = EAGAIN;
  std::string path;
  for (int i = 0; i < kTriesMax; ++i) {
    path = absl::StrCat(path_, "/", DrawName());
    const int descriptor =
        open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kOwnUserOnly);
    if (descriptor < 0) {
      error = errno;
      if (error == EEXIST) {
        continue;
      }
      break;
    }
    if (Lock(descriptor)) {
      return std::make_unique<SharedFile>(path, descriptor);
    }
    close(descriptor);
  }
  return absl::ResourceExhaustedError(
      absl::StrCat("cannot make ", path, ": ", std::generic_category().message(error)));
}

}  // namespace procgen
