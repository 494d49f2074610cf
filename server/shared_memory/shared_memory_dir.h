#ifndef SERVER_SHARED_MEMORY_SHARED_MEMORY_DIR_H_
#define SERVER_SHARED_MEMORY_SHARED_MEMORY_DIR_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace procgen {

// A file that this process creates and removes, and that other processes map. Mappings keep the
// memory alive.
// Threads: compatible.
class SharedFile {
 public:
  // Takes over a created and locked file.
  SharedFile(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  ~SharedFile();
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;

  const std::string& path() const { return path_; }
  int descriptor() const { return descriptor_; }

 private:
  const std::string path_;
  const int descriptor_;
};

// The directory of a server's shared files, e.g. /dev/shm. Several servers may share it. A live
// server's files are locked; a starting server removes files of killed ones. Only processes of the
// same user can open the files.
// Threads: any method from any thread.
class SharedMemoryDir {
 public:
  // Also removes stale files. Errors: INVALID_ARGUMENT not a directory in which files can be
  // created.
  static absl::StatusOr<std::unique_ptr<SharedMemoryDir>> Open(const std::string& path);

  const std::string& path() const { return path_; }
  // Number of stale files that were removed.
  int stale_file_count() const { return stale_file_count_; }

  // Creates an empty file. Errors: RESOURCE_EXHAUSTED, with its path and the reason.
  absl::StatusOr<std::unique_ptr<SharedFile>> MakeFile() const;

 private:
  SharedMemoryDir(std::string path, int stale_file_count)
      : path_(std::move(path)), stale_file_count_(stale_file_count) {}

  const std::string path_;
  const int stale_file_count_;
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_SHARED_MEMORY_DIR_H_
