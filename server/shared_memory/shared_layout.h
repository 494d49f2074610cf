#ifndef SERVER_SHARED_MEMORY_SHARED_LAYOUT_H_
#define SERVER_SHARED_MEMORY_SHARED_LAYOUT_H_

#include <cstdint>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"

namespace procgen {

// An array of a batch in shared memory.
struct SharedArray {
  enum class Element : uint8_t { kUint8, kBool, kInt32, kInt64, kFloat32 };

  absl::string_view field;  // of procgen.v1.Batch
  int64_t offset_bytes = 0;
  Element element = Element::kUint8;
  bool is_pictures = false;  // a row is an observation, otherwise a number
};

// The offsets of the arrays of a batch in shared memory: consecutive, each aligned for SIMD, with a
// row per environment of the pool.
// Threads: immutable.
class SharedLayout {
 public:
  SharedLayout(int32_t env_count, int64_t observation_bytes);

  // Size of one batch; a multiple of 4096.
  int64_t batch_bytes() const { return batch_bytes_; }
  absl::Span<const SharedArray> arrays() const { return arrays_; }

  // The rows of environments [first, first + count) in the batch that begins at `memory`.
  Batch Rows(uint8_t* memory, int32_t first, int32_t count) const;

 private:
  int64_t observation_bytes_;
  std::vector<SharedArray> arrays_;
  int64_t batch_bytes_ = 0;
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_SHARED_LAYOUT_H_
