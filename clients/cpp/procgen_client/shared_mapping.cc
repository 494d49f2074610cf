#include "procgen_client/shared_mapping.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;

// The names of the fields, in the order of SharedField, and what their elements are.
const std::pair<const char*, v1::ElementType> kFields[kSharedFieldCount] = {
    {"observations", v1::ELEMENT_TYPE_UINT8},
    {"final_observations", v1::ELEMENT_TYPE_UINT8},
    {"fingerprints", v1::ELEMENT_TYPE_INT64},
    {"rewards", v1::ELEMENT_TYPE_FLOAT32},
    {"episode_returns", v1::ELEMENT_TYPE_FLOAT32},
    {"level_seeds", v1::ELEMENT_TYPE_INT32},
    {"prev_level_seeds", v1::ELEMENT_TYPE_INT32},
    {"episode_lengths", v1::ELEMENT_TYPE_INT32},
    {"first", v1::ELEMENT_TYPE_BOOL},
    {"terminated", v1::ELEMENT_TYPE_BOOL},
    {"truncated", v1::ELEMENT_TYPE_BOOL},
    {"prev_level_complete", v1::ELEMENT_TYPE_BOOL},
};

int64_t ElementBytes(v1::ElementType type) {
  switch (type) {
    case v1::ELEMENT_TYPE_INT64:
      return 8;
    case v1::ELEMENT_TYPE_INT32:
    case v1::ELEMENT_TYPE_FLOAT32:
      return 4;
    default:
      return 1;
  }
}

absl::Status Wrong(const v1::SharedMemory& memory, absl::string_view what) {
  return absl::InternalError(absl::StrCat("the server's shared memory ", memory.path(), " ", what));
}

const v1::SharedArray* Find(const v1::SharedMemory& memory, absl::string_view field) {
  for (const v1::SharedArray& array : memory.arrays()) {
    if (array.field() == field) {
      return &array;
    }
  }
  return nullptr;
}

// Bytes of a row, or -1: its shape makes no sense or it does not fit.
int64_t RowBytes(const v1::SharedArray& array, int64_t batch_bytes) {
  constexpr int64_t kAlignment = 64;
  int64_t bytes = ElementBytes(array.element_type());
  for (int i = 1; i < array.shape_size(); ++i) {
    if (array.shape(i) < 1 || bytes > batch_bytes / array.shape(i)) {
      return -1;
    }
    bytes *= array.shape(i);
  }
  const int64_t offset = array.offset_bytes();
  const bool fits = offset >= 0 && offset % kAlignment == 0 && offset <= batch_bytes &&
                    bytes <= (batch_bytes - offset) / array.shape(0);
  return fits ? bytes : -1;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const SharedMapping>> SharedMapping::Open(
    const v1::SharedMemory& memory) {
  const std::shared_ptr<SharedMapping> mapping(new SharedMapping());
  absl::Status status = mapping->Read(memory);
  if (status.ok()) {
    status = mapping->Map();
  }
  if (!status.ok()) {
    return status;
  }
  return mapping;
}

SharedMapping::~SharedMapping() {
  if (memory_ != nullptr) {
    munmap(const_cast<uint8_t*>(memory_), static_cast<size_t>(size_bytes_));
  }
}

absl::Status SharedMapping::Read(const v1::SharedMemory& memory) {
  path_ = memory.path();
  size_bytes_ = memory.size_bytes();
  batch_count_ = memory.batch_count();
  batch_bytes_ = memory.batch_bytes();
  if (batch_count_ < 1 || batch_bytes_ < 1 || size_bytes_ % batch_count_ != 0 ||
      size_bytes_ / batch_count_ != batch_bytes_) {
    return Wrong(memory, absl::StrCat("has ", size_bytes_, " bytes, ", batch_count_, " x ",
                                      batch_bytes_, " are told"));
  }
  for (size_t i = 0; i < kSharedFieldCount; ++i) {
    const auto& [field, type] = kFields[i];
    const v1::SharedArray* array = Find(memory, field);
    if (array == nullptr || array->element_type() != type || array->shape_size() < 1 ||
        array->shape(0) < 1 || (env_count_ != 0 && array->shape(0) != env_count_)) {
      return Wrong(memory, absl::StrCat("has no array ", field, " of its type and rows"));
    }
    env_count_ = array->shape(0);
    const int64_t row_bytes = RowBytes(*array, batch_bytes_);
    if (row_bytes < 0) {
      return Wrong(memory, absl::StrCat("has an array ", field, " that does not fit in a batch"));
    }
    arrays_[i] = {array->offset_bytes(), row_bytes};
  }
  return absl::OkStatus();
}

absl::Status SharedMapping::Map() {
  const int file = open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat facts = {};
  std::string error;
  if (file < 0 || fstat(file, &facts) != 0) {
    error = std::generic_category().message(errno);
  } else if (facts.st_size < size_bytes_) {
    // What lies behind the end of a file cannot be read, and ends who tries.
    error = absl::StrCat("it has ", facts.st_size, " bytes and is shorter than ", size_bytes_);
  } else {
    void* memory = mmap(nullptr, static_cast<size_t>(size_bytes_), PROT_READ, MAP_SHARED, file, 0);
    if (memory == MAP_FAILED) {
      error = std::generic_category().message(errno);
    } else {
      memory_ = static_cast<const uint8_t*>(memory);
    }
  }
  if (file >= 0) {
    close(file);
  }
  if (!error.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "cannot map the pool's shared memory ", path_, ": ", error,
        "; it can be mapped on the server's machine (and in its container), by its user; elsewhere "
        "make the pool with TRANSPORT_STREAM"));
  }
  return absl::OkStatus();
}

void HeldBatches::Hold(int32_t batch) {
  absl::MutexLock lock(&mutex_);
  held_.push_back(batch);
}

void HeldBatches::Release(int32_t batch) {
  absl::MutexLock lock(&mutex_);
  const auto found = std::find(held_.begin(), held_.end(), batch);
  if (found != held_.end()) {
    held_.erase(found);
    released_.push_back(batch);
  }
}

int32_t HeldBatches::count() const {
  absl::MutexLock lock(&mutex_);
  return static_cast<int32_t>(held_.size());
}

void HeldBatches::TakeReleased(google::protobuf::RepeatedField<int32_t>* released) {
  absl::MutexLock lock(&mutex_);
  released->Assign(released_.begin(), released_.end());
  released_.clear();
}

std::vector<int32_t> HeldBatches::TakeHeld() {
  absl::MutexLock lock(&mutex_);
  released_.clear();
  return held_;
}

absl::StatusOr<std::shared_ptr<const SharedRows>> SharedRows::Hold(
    std::shared_ptr<const SharedMapping> mapping, std::shared_ptr<HeldBatches> held,
    const v1::Batch& batch) {
  const int32_t count = batch.environment_count();
  if (mapping == nullptr || batch.shared_batch() < 0 ||
      batch.shared_batch() >= mapping->batch_count() || batch.first_environment() < 0 ||
      count < 1 || count > mapping->env_count() ||
      batch.first_environment() > mapping->env_count() - count) {
    return absl::InternalError(absl::StrCat(
        "the server answers with environments ", batch.first_environment(), " and ", count - 1,
        " more in batch ", batch.shared_batch(), " of shared memory, which there are not"));
  }
  return std::shared_ptr<const SharedRows>(
      new SharedRows(std::move(mapping), std::move(held), batch));
}

SharedRows::SharedRows(std::shared_ptr<const SharedMapping> mapping,
                       std::shared_ptr<HeldBatches> held, const v1::Batch& batch)
    : mapping_(std::move(mapping)), held_(std::move(held)), batch_(batch.shared_batch()) {
  held_->Hold(batch_);
  const int32_t from = batch.first_environment();
  const int32_t count = batch.environment_count();
  rewards = mapping_->Rows<float>(batch_, SharedField::kRewards, from, count);
  first = mapping_->Rows<bool>(batch_, SharedField::kFirst, from, count);
  terminated = mapping_->Rows<bool>(batch_, SharedField::kTerminated, from, count);
  truncated = mapping_->Rows<bool>(batch_, SharedField::kTruncated, from, count);
  level_seeds = mapping_->Rows<int32_t>(batch_, SharedField::kLevelSeeds, from, count);
  prev_level_seeds = mapping_->Rows<int32_t>(batch_, SharedField::kPrevLevelSeeds, from, count);
  prev_level_complete = mapping_->Rows<bool>(batch_, SharedField::kPrevLevelComplete, from, count);
  episode_returns = mapping_->Rows<float>(batch_, SharedField::kEpisodeReturns, from, count);
  episode_lengths = mapping_->Rows<int32_t>(batch_, SharedField::kEpisodeLengths, from, count);
  int32_t ended = 0;
  for (size_t row = 0; row < terminated.size(); ++row) {
    ended += terminated[row] || truncated[row] ? 1 : 0;
  }
  fingerprints = mapping_->Rows<uint64_t>(batch_, SharedField::kFingerprints, from, ended);
  if (batch.shared_final_observations()) {
    final_observations =
        mapping_->Rows<uint8_t>(batch_, SharedField::kFinalObservations, from, ended);
  }
  if (batch.shared_observations()) {
    observations = mapping_->Rows<uint8_t>(batch_, SharedField::kObservations, from, count);
  }
}

}  // namespace procgen_client
