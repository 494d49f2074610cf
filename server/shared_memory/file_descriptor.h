#ifndef SERVER_SHARED_MEMORY_FILE_DESCRIPTOR_H_
#define SERVER_SHARED_MEMORY_FILE_DESCRIPTOR_H_

#include <unistd.h>

#include <utility>

namespace procgen {

// An owned file descriptor, closed on destruction. Threads: compatible.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  // Takes ownership; negative: none.
  explicit FileDescriptor(int number) : number_(number) {}
  ~FileDescriptor() {
    if (is_open()) {
      close(number_);
    }
  }
  FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }

  bool is_open() const { return number_ >= 0; }
  // The raw descriptor; negative: none.
  int number() const { return number_; }

 private:
  int number_ = -1;
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_FILE_DESCRIPTOR_H_
