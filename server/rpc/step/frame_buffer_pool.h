#ifndef SERVER_RPC_STEP_FRAME_BUFFER_POOL_H_
#define SERVER_RPC_STEP_FRAME_BUFFER_POOL_H_

#include <cstddef>
#include <cstdint>
#include <memory>

#include "absl/types/span.h"
#include "grpcpp/support/slice.h"

namespace procgen {

// Memory that frames are drawn into and that is then sent as it is.
struct Frames {
  grpc::Slice slice;          // holds the memory; empty: none
  absl::Span<uint8_t> bytes;  // the same, to be written
};

// Memory of frames that goes round: it comes back when the last copy of its slice is gone (gRPC has
// sent it, and no answer that is kept refers to it), and is taken again. Slices may outlive the
// ring.
// Threads: compatible; slices may be let go of on any thread, at any time, under any lock.
class FrameBufferPool {
 public:
  FrameBufferPool();
  ~FrameBufferPool();
  FrameBufferPool(const FrameBufferPool&) = delete;
  FrameBufferPool& operator=(const FrameBufferPool&) = delete;

  // Memory of `size` bytes, of any content.
  Frames Take(size_t size);

 private:
  class Shelf;
  struct Memory;

  const std::shared_ptr<Shelf> shelf_;  // what came back
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_FRAME_BUFFER_POOL_H_
