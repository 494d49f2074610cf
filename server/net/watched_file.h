#ifndef SERVER_NET_WATCHED_FILE_H_
#define SERVER_NET_WATCHED_FILE_H_

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>

#include "absl/status/statusor.h"

namespace procgen {

// A small file that is read again after it was written or replaced. The user polls HasChanged.
// Threads: compatible (one at a time).
class WatchedFile {
 public:
  static constexpr size_t kBytesMax = 1 << 20;

  explicit WatchedFile(std::string path) : path_(std::move(path)) {}

  const std::string& path() const { return path_; }

  // Returns its contents. Errors, which name the file: NOT_FOUND, PERMISSION_DENIED ... it cannot
  // be read; INVALID_ARGUMENT it is not a regular file, or is larger than kBytesMax.
  absl::StatusOr<std::string> Read();

  // Whether it was replaced or written since the last Read, successful or not.
  bool HasChanged() const;

  // Whether all users of the machine could read it at the last Read.
  bool is_world_readable() const { return is_world_readable_; }

 private:
  // Device, inode, size, and the times of its last writing and change; none: there is no file.
  using Stamp = std::optional<std::tuple<uint64_t, uint64_t, int64_t, int64_t, int64_t>>;
  static Stamp StampOf(const struct stat& file);

  std::string path_;
  Stamp stamp_;
  bool is_world_readable_ = false;
};

}  // namespace procgen

#endif  // SERVER_NET_WATCHED_FILE_H_
