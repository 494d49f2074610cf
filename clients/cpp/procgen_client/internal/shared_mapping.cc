#include "procgen_client/internal/shared_mapping.h"

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

// Name and element type of each field, in the order of SharedField.
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

// Returns an error text if an array does not have `env_count` rows of `row_bytes`; else empty.
std::string WhatIsWrong(const v1::SharedArray& array, v1::ElementType type, int64_t env_count,
                        int64_t row_bytes, int64_t batch_bytes) {
  constexpr int64_t kAlignment = 64;
  int64_t bytes = ElementBytes(type);
  for (int i = 1; i < array.shape_size() && bytes <= row_bytes; ++i) {
    bytes =
        array.shape(i) < 1 || array.shape(i) > row_bytes ? row_bytes + 1 : bytes * array.shape(i);
  }
  if (array.element_type() != type || array.shape_size() < 1 || array.shape(0) != env_count ||
      bytes != row_bytes) {
    return absl::StrCat("of another type or shape, expected: ", env_count, " rows of ", row_bytes,
                        " bytes");
  }
  const int64_t offset_max = batch_bytes - env_count * row_bytes;
  const int64_t offset = array.offset_bytes();
  if (offset < 0 || offset > offset_max || offset % kAlignment != 0) {
    return absl::StrCat("at ", offset, ", expected: a multiple of ", kAlignment, " up to ",
                        offset_max);
  }
  return "";
}

}  // namespace

absl::StatusOr<std::shared_ptr<const SharedMapping>> SharedMapping::Open(
    const v1::SharedMemory& memory, const v1::Pool& pool) {
  const std::shared_ptr<SharedMapping> mapping(new SharedMapping());
  absl::Status status = mapping->Read(memory, pool);
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

absl::Status SharedMapping::Read(const v1::SharedMemory& memory, const v1::Pool& pool) {
  path_ = memory.path();
  size_bytes_ = memory.size_bytes();
  batch_count_ = memory.batch_count();
  batch_bytes_ = memory.batch_bytes();
  if (batch_count_ < 1 || batch_bytes_ < 1 || size_bytes_ % batch_count_ != 0 ||
      size_bytes_ / batch_count_ != batch_bytes_) {
    return Wrong(memory, absl::StrCat("has ", size_bytes_, " bytes, ", batch_count_, " x ",
                                      batch_bytes_, " expected"));
  }
  for (size_t i = 0; i < kSharedFieldCount; ++i) {
    const auto& [field, type] = kFields[i];
    const v1::SharedArray* array = Find(memory, field);
    if (array == nullptr) {
      return Wrong(memory, absl::StrCat("has no array ", field));
    }
    const int64_t row_bytes =
        type == v1::ELEMENT_TYPE_UINT8 ? pool.observation_bytes() : ElementBytes(type);
    const std::string wrong =
        WhatIsWrong(*array, type, pool.spec().env_count(), row_bytes, batch_bytes_);
    if (!wrong.empty()) {
      return Wrong(memory, absl::StrCat("has an array ", field, " ", wrong));
    }
    arrays_[i] = {array->offset_bytes(), row_bytes};
  }
  return absl::OkStatus();
}

absl::Status SharedMapping::Map() {
  // O_NONBLOCK: opening a FIFO must not block.
  const int file = open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat facts = {};
  std::string error;
  if (file < 0 || fstat(file, &facts) != 0) {
    error = std::generic_category().message(errno);
  } else if (!S_ISREG(facts.st_mode)) {
    error = "it is not a regular file";
  } else if (facts.st_size < size_bytes_) {
    // Reading a mapping beyond the end of the file raises SIGBUS.
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

bool HeldBatches::Hold(int32_t batch) {
  absl::MutexLock lock(&mutex_);
  if (std::find(held_.begin(), held_.end(), batch) != held_.end()) {
    return false;
  }
  held_.push_back(batch);
  return true;
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
  if (!held->Hold(batch.shared_batch())) {
    return absl::DataLossError(absl::StrCat("the server answers in batch ", batch.shared_batch(),
                                            " of shared memory, expected: one that is not held"));
  }
  return std::shared_ptr<const SharedRows>(
      new SharedRows(std::move(mapping), std::move(held), batch));
}

SharedRows::SharedRows(std::shared_ptr<const SharedMapping> mapping,
                       std::shared_ptr<HeldBatches> held, const v1::Batch& batch)
    : mapping_(std::move(mapping)), held_(std::move(held)), batch_(batch.shared_batch()) {
  const int32_t from = batch.first_env();
  const int32_t count = batch.env_count();
  rewards = mapping_->Rows<float>(batch_, SharedField::kRewards, from, count);
  first = mapping_->Rows<bool>(batch_, SharedField::kFirst, from, count);
  terminated = mapping_->Rows<bool>(batch_, SharedField::kTerminated, from, count);
  truncated = mapping_->Rows<bool>(batch_, SharedField::kTruncated, from, count);
  level_seeds = mapping_->Rows<int32_t>(batch_, SharedField::kLevelSeeds, from, count);
  prev_level_seeds = mapping_->Rows<int32_t>(batch_, SharedField::kPrevLevelSeeds, from, count);
  prev_level_complete = mapping_->Rows<bool>(batch_, SharedField::kPrevLevelComplete, from, count);
  episode_returns = mapping_->Rows<float>(batch_, SharedField::kEpisodeReturns, from, count);
  episode_lengths = mapping_->Rows<int32_t>(batch_, SharedField::kEpisodeLengths, from, count);
  // As bytes: a bool that is neither 0 nor 1, as another server may write it, must not be read.
  const auto* const flags = reinterpret_cast<const uint8_t*>(terminated.data());
  const auto* const more_flags = reinterpret_cast<const uint8_t*>(truncated.data());
  int32_t ended = 0;
  for (int32_t row = 0; row < count; ++row) {
    ended += flags[row] != 0 || more_flags[row] != 0 ? 1 : 0;
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
