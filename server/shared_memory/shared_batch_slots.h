#ifndef SERVER_SHARED_MEMORY_SHARED_BATCH_SLOTS_H_
#define SERVER_SHARED_MEMORY_SHARED_BATCH_SLOTS_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "envcore/pool/pool.h"
#include "server/shared_memory/mapping_guard.h"
#include "server/shared_memory/shared_layout.h"
#include "server/shared_memory/shared_memory_dir.h"

namespace procgen {

// The batches of a pool in memory that learners on the same machine map: a file in which batch k
// begins at k * layout().batch_bytes(). SlotTable tracks their use.
// Threads: Grow alone; Rows from any thread.
class SharedBatchSlots {
 public:
  // Starts without batches. `folder` must outlive this.
  SharedBatchSlots(const SharedMemoryDir* folder, int32_t env_count, int64_t observation_bytes)
      : folder_(folder), layout_(env_count, observation_bytes) {}
  ~SharedBatchSlots();
  SharedBatchSlots(const SharedBatchSlots&) = delete;
  SharedBatchSlots& operator=(const SharedBatchSlots&) = delete;

  // Grows to at least `batch_count` batches. Existing mappings and contents stay. Memory is
  // allocated here, so that later writes cannot fail. May take long.
  // Errors: RESOURCE_EXHAUSTED no space (with path, bytes and reason), and nothing has changed;
  // FAILED_PRECONDITION the file was truncated, so learners no longer see what is written.
  absl::Status Grow(int32_t batch_count);

  const SharedLayout& layout() const { return layout_; }
  int32_t batch_count() const { return batch_count_; }
  int64_t size_bytes() const { return batch_count_ * layout_.batch_bytes(); }
  // REQUIRES: it has a batch.
  const std::string& path() const { return file_->path(); }

  // The writable rows of environments [first, first + count) in batch number `batch`.
  Batch Rows(int32_t batch, int32_t first, int32_t count) const {
    return layout_.Rows(memory_ + batch * layout_.batch_bytes(), first, count);
  }

 private:
  const SharedMemoryDir* const folder_;
  const SharedLayout layout_;
  int32_t batch_count_ = 0;
  std::unique_ptr<SharedFile> file_;     // null: no batch
  uint8_t* memory_ = nullptr;            // [size_bytes()]
  std::unique_ptr<MappingGuard> guard_;  // of memory_
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_SHARED_BATCH_SLOTS_H_
