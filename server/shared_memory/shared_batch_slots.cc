#include "server/shared_memory/shared_batch_slots.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <system_error>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

// Allocates the file's memory: a page missing at the first write would end the process. Returns an
// errno value, or 0.
int Extend(int descriptor, int64_t from_bytes, int64_t to_bytes) {
  int error = EINTR;
  while (error == EINTR) {
    error = posix_fallocate(descriptor, from_bytes, to_bytes - from_bytes);
  }
  return error;
}

}  // namespace

SharedBatchSlots::~SharedBatchSlots() {
  guard_ = nullptr;
  if (memory_ != nullptr) {
    munmap(memory_, static_cast<size_t>(size_bytes()));
  }
}

absl::Status SharedBatchSlots::Grow(int32_t batch_count) {
  if (guard_ != nullptr && guard_->was_replaced()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "somebody has truncated ", file_->path(), ", the pool's shared memory; delete the pool"));
  }
  if (batch_count <= batch_count_) {
    return absl::OkStatus();
  }
  std::unique_ptr<SharedFile> made;
  if (file_ == nullptr) {
    absl::StatusOr<std::unique_ptr<SharedFile>> file = folder_->MakeFile();
    if (!file.ok()) {
      return file.status();
    }
    made = *std::move(file);
  }
  const SharedFile& file = made != nullptr ? *made : *file_;
  const int64_t bytes = batch_count * layout_.batch_bytes();
  int error = Extend(file.descriptor(), size_bytes(), bytes);
  void* memory = MAP_FAILED;
  if (error == 0) {
    memory = mmap(nullptr, static_cast<size_t>(bytes), PROT_READ | PROT_WRITE, MAP_SHARED,
                  file.descriptor(), 0);
    error = memory == MAP_FAILED ? errno : 0;
  }
  if (error != 0) {
    const bool cut = ftruncate(file.descriptor(), size_bytes()) == 0;
    return absl::ResourceExhaustedError(absl::StrCat(
        "shared memory of ", bytes, " bytes in ", file.path(), ": ",
        std::generic_category().message(error), cut ? "" : " (and it stays so large)"));
  }
  if (memory_ != nullptr) {
    guard_ = nullptr;
    munmap(memory_, static_cast<size_t>(size_bytes()));
  }
  guard_ = std::make_unique<MappingGuard>(memory, static_cast<size_t>(bytes));
  if (made != nullptr) {
    file_ = std::move(made);
  }
  memory_ = static_cast<uint8_t*>(memory);
  batch_count_ = batch_count;
  return absl::OkStatus();
}

}  // namespace procgen
