#ifndef SERVER_SHARED_MEMORY_SHARED_FOLDER_H_
#define SERVER_SHARED_MEMORY_SHARED_FOLDER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace procgen {

// A file that is mapped by this process and by others, and that this one removes. Whoever has it
// mapped keeps the memory.
// Threads: compatible.
class SharedFile {
 public:
  // Takes over what was made and locked.
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

// The folder where a server makes such files, e.g. /dev/shm. Servers may share it, and what one
// that was killed has left is removed by the next that starts: as long as a server lives, its files
// are locked. Only processes of the same user can open them.
// Threads: any method from any thread.
class SharedFolder {
 public:
  // Also removes what servers have left there. Errors: INVALID_ARGUMENT no folder that files can be
  // made in.
  static absl::StatusOr<std::unique_ptr<SharedFolder>> Open(const std::string& path);

  const std::string& path() const { return path_; }
  // How many files other servers had left.
  int stale_file_count() const { return stale_file_count_; }

  // Makes an empty file. Errors: RESOURCE_EXHAUSTED, with its path and why.
  absl::StatusOr<std::unique_ptr<SharedFile>> MakeFile() const;

 private:
  SharedFolder(std::string path, int stale_file_count)
      : path_(std::move(path)), stale_file_count_(stale_file_count) {}

  const std::string path_;
  const int stale_file_count_;
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_SHARED_FOLDER_H_
