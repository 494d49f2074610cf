#ifndef SERVER_ENCODING_BYTE_LIST_H_
#define SERVER_ENCODING_BYTE_LIST_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace procgen {

// Bytes that are appended without a check of each, and whose memory is kept for the next time.
// Threads: compatible (one thread at a time).
class ByteList {
 public:
  // Where up to `count` bytes may be written; whoever wrote tells by Extend how many there are.
  uint8_t* Room(size_t count) {
    if (memory_.size() - size_ < count) {
      memory_.resize(size_ + count + memory_.size() / 2);
    }
    return memory_.data() + size_;
  }
  // REQUIRES: what was asked for by Room is no less.
  void Extend(size_t count) { size_ += count; }

  void Clear() { size_ = 0; }
  absl::Span<const uint8_t> bytes() const { return {memory_.data(), size_}; }

 private:
  std::vector<uint8_t> memory_;
  size_t size_ = 0;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_BYTE_LIST_H_
