#include "server/rpc/step/frame_buffer_pool.h"

#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {
namespace {

// What may lie on the shelf: that of one response that is drawn, one that is on its way and one
// that gRPC has not let go of yet.
constexpr size_t kOnShelfMax = 3;

}  // namespace

struct FrameBufferPool::Memory {
  std::unique_ptr<uint8_t[]> bytes;
  size_t size = 0;
};

class FrameBufferPool::Shelf {
 public:
  // Memory of at least `size` bytes.
  Memory Take(size_t size) {
    {
      absl::MutexLock lock(&mutex_);
      while (!free_.empty()) {
        Memory memory = std::move(free_.back());
        free_.pop_back();
        if (memory.size >= size) {
          return memory;
        }
      }
    }
    // Left as it is: it is drawn over.
    return {std::make_unique_for_overwrite<uint8_t[]>(size), size};
  }

  void PutBack(Memory memory) {
    absl::MutexLock lock(&mutex_);
    if (free_.size() < kOnShelfMax) {
      free_.push_back(std::move(memory));
    }
  }

 private:
  absl::Mutex mutex_;
  std::vector<Memory> free_ ABSL_GUARDED_BY(mutex_);
};

FrameBufferPool::FrameBufferPool() : shelf_(std::make_shared<Shelf>()) {}

FrameBufferPool::~FrameBufferPool() = default;

Frames FrameBufferPool::Take(size_t size) {
  if (size == 0) {
    return {};
  }
  struct Lent {
    Memory memory;
    std::shared_ptr<Shelf> shelf;
  };
  const auto take_back = [](void* held) {
    const std::unique_ptr<Lent> lent(static_cast<Lent*>(held));
    lent->shelf->PutBack(std::move(lent->memory));
  };
  auto lent = std::make_unique<Lent>();
  lent->memory = shelf_->Take(size);
  lent->shelf = shelf_;
  uint8_t* const bytes = lent->memory.bytes.get();
  return {grpc::Slice(bytes, size, take_back, lent.release()), absl::MakeSpan(bytes, size)};
}

}  // namespace procgen
