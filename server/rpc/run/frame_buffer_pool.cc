#include "server/rpc/run/frame_buffer_pool.h"

#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {
namespace {

// Largest length of the free list: buffers of a response being drawn, one being sent, and one that
// gRPC has not released yet.
constexpr size_t kFreeBuffersMax = 3;

}  // namespace

struct FrameBufferPool::Buffer {
  std::unique_ptr<uint8_t[]> bytes;
  size_t size = 0;
};

class FrameBufferPool::FreeList {
 public:
  // Returns a buffer of at least `size` bytes.
  Buffer Take(size_t size) {
    {
      absl::MutexLock lock(&mutex_);
      while (!free_.empty()) {
        Buffer buffer = std::move(free_.back());
        free_.pop_back();
        if (buffer.size >= size) {
          return buffer;
        }
      }
    }
    // Not initialised, because it is drawn over.
    return {std::make_unique_for_overwrite<uint8_t[]>(size), size};
  }

  void PutBack(Buffer buffer) {
    absl::MutexLock lock(&mutex_);
    if (free_.size() < kFreeBuffersMax) {
      free_.push_back(std::move(buffer));
    }
  }

 private:
  absl::Mutex mutex_;
  std::vector<Buffer> free_ ABSL_GUARDED_BY(mutex_);
};

FrameBufferPool::FrameBufferPool() : free_list_(std::make_shared<FreeList>()) {}

FrameBufferPool::~FrameBufferPool() = default;

Frames FrameBufferPool::Take(size_t size) {
  if (size == 0) {
    return {};
  }
  struct BufferInUse {
    Buffer buffer;
    std::shared_ptr<FreeList> free_list;
  };
  const auto release = [](void* held) {
    const std::unique_ptr<BufferInUse> in_use(static_cast<BufferInUse*>(held));
    in_use->free_list->PutBack(std::move(in_use->buffer));
  };
  auto in_use = std::make_unique<BufferInUse>();
  in_use->buffer = free_list_->Take(size);
  in_use->free_list = free_list_;
  uint8_t* const bytes = in_use->buffer.bytes.get();
  return {grpc::Slice(bytes, size, release, in_use.release()), absl::MakeSpan(bytes, size)};
}

}  // namespace procgen
