#ifndef SERVER_ENCODING_BYTE_LIST_H_
#define SERVER_ENCODING_BYTE_LIST_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace procgen {

// A byte buffer with unchecked appends and reused memory.
// Threads: compatible (one thread at a time).
class ByteList {
 public:
  // Returns memory for up to `count` bytes. The writer then calls Extend with the number written.
  uint8_t* Room(size_t count) {
    if (memory_.size() - size_ < count) {
      memory_.resize(size_ + count + memory_.size() / 2);
    }
    return memory_.data() + size_;
  }
  // REQUIRES: `count` is at most that of Room.
  void Extend(size_t count) { size_ += count; }

  void Clear() { size_ = 0; }
  absl::Span<const uint8_t> bytes() const { return {memory_.data(), size_}; }

 private:
  std::vector<uint8_t> memory_;
  size_t size_ = 0;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_BYTE_LIST_H_
