#ifndef SERVER_RPC_RUN_FRAME_BUFFER_POOL_H_
#define SERVER_RPC_RUN_FRAME_BUFFER_POOL_H_

#include <cstddef>
#include <cstdint>
#include <memory>

#include "absl/types/span.h"
#include "grpcpp/support/slice.h"

namespace procgen {

// Memory that workers draw frames into and gRPC sends without a copy.
struct Frames {
  grpc::Slice slice;          // owns the memory; empty: none
  absl::Span<uint8_t> bytes;  // the same memory, writable
};

// Allocates memory for frames and reuses it. A buffer returns to the pool when the last copy of its
// slice is destroyed: gRPC has sent it. Slices may outlive the
// pool.
// Threads: compatible; slices may be destroyed on any thread, at any time, under any lock.
class FrameBufferPool {
 public:
  FrameBufferPool();
  ~FrameBufferPool();
  FrameBufferPool(const FrameBufferPool&) = delete;
  FrameBufferPool& operator=(const FrameBufferPool&) = delete;

  // Returns `size` bytes of uninitialised memory.
  Frames Take(size_t size);

 private:
  class FreeList;
  struct Buffer;

  const std::shared_ptr<FreeList> free_list_;  // shared with the slices
};

}  // namespace procgen

#endif  // SERVER_RPC_RUN_FRAME_BUFFER_POOL_H_
