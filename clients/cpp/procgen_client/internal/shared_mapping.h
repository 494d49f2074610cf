#ifndef PROCGEN_CLIENT_INTERNAL_SHARED_MAPPING_H_
#define PROCGEN_CLIENT_INTERNAL_SHARED_MAPPING_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/types/span.h"
#include "google/protobuf/repeated_field.h"
#include "procgen/v1/step.pb.h"

namespace procgen_client {

// The arrays of a batch in shared memory, each a field of procgen.v1.Batch.
enum class SharedField : uint8_t {
  kObservations,
  kFinalObservations,
  kFingerprints,
  kRewards,
  kEpisodeReturns,
  kLevelSeeds,
  kPrevLevelSeeds,
  kEpisodeLengths,
  kFirst,
  kTerminated,
  kTruncated,
  kPrevLevelComplete,
};
inline constexpr size_t kSharedFieldCount = 12;

// A read-only mapping of the memory that a pool shares with its learners
// (procgen.v1.SharedMemory).
// Threads: immutable; the server writes its content by the rules of procgen.v1.SharedMemory.
class SharedMapping {
 public:
  // Maps the memory. Errors: FAILED_PRECONDITION the file cannot be opened or mapped by this
  // process; INTERNAL its description does not match the pool.
  static absl::StatusOr<std::shared_ptr<const SharedMapping>> Open(
      const procgen::v1::SharedMemory& memory, const procgen::v1::Pool& pool);
  ~SharedMapping();
  SharedMapping(const SharedMapping&) = delete;
  SharedMapping& operator=(const SharedMapping&) = delete;

  const std::string& path() const { return path_; }
  int32_t batch_count() const { return batch_count_; }

  // Rows [first, first + count) of the array `field` in a batch. REQUIRES: all are in range, and
  // Element is the field's type.
  template <typename Element>
  absl::Span<const Element> Rows(int32_t batch, SharedField field, int32_t first,
                                 int32_t count) const {
    const Array& array = arrays_[static_cast<size_t>(field)];
    const uint8_t* begin = memory_ + batch * batch_bytes_ + array.offset_bytes;
    return absl::MakeConstSpan(reinterpret_cast<const Element*>(begin + first * array.row_bytes),
                               static_cast<size_t>(count * array.row_bytes) / sizeof(Element));
  }

 private:
  struct Array {
    int64_t offset_bytes = 0;
    int64_t row_bytes = 0;
  };

  SharedMapping() = default;
  // Reads and validates the description. Errors: INTERNAL.
  absl::Status Read(const procgen::v1::SharedMemory& memory, const procgen::v1::Pool& pool);
  absl::Status Map();

  std::string path_;
  int64_t size_bytes_ = 0;
  int32_t batch_count_ = 0;
  int64_t batch_bytes_ = 0;
  std::array<Array, kSharedFieldCount> arrays_;  // by field
  const uint8_t* memory_ = nullptr;
};

// The batches of a mapping that a learner holds, and those that it has released since its last
// request.
// Threads: any method from any thread.
class HeldBatches {
 public:
  // False: the batch is held already.
  bool Hold(int32_t batch);
  void Release(int32_t batch);

  int32_t count() const;
  // Moves the released batches to `released`.
  void TakeReleased(google::protobuf::RepeatedField<int32_t>* released);
  // Returns the batches held, for Attach.held_batches, and clears the released ones, which
  // attaching releases.
  std::vector<int32_t> TakeHeld();

 private:
  mutable absl::Mutex mutex_;
  std::vector<int32_t> held_ ABSL_GUARDED_BY(mutex_);
  std::vector<int32_t> released_ ABSL_GUARDED_BY(mutex_);
};

// The rows of an answer in shared memory. Holds their batch until destroyed.
class SharedRows {
 public:
  // Holds the rows of `batch`. REQUIRES: ResponseValidator has accepted it. Errors: DATA_LOSS its
  // shared batch is held already.
  static absl::StatusOr<std::shared_ptr<const SharedRows>> Hold(
      std::shared_ptr<const SharedMapping> mapping, std::shared_ptr<HeldBatches> held,
      const procgen::v1::Batch& batch);
  ~SharedRows() { held_->Release(batch_); }
  SharedRows(const SharedRows&) = delete;
  SharedRows& operator=(const SharedRows&) = delete;

  absl::Span<const uint8_t> observations;
  absl::Span<const float> rewards;
  absl::Span<const bool> first;
  absl::Span<const bool> terminated;
  absl::Span<const bool> truncated;
  absl::Span<const int32_t> level_seeds;
  absl::Span<const int32_t> prev_level_seeds;
  absl::Span<const bool> prev_level_complete;
  absl::Span<const float> episode_returns;
  absl::Span<const int32_t> episode_lengths;
  absl::Span<const uint64_t> fingerprints;
  absl::Span<const uint8_t> final_observations;

 private:
  SharedRows(std::shared_ptr<const SharedMapping> mapping, std::shared_ptr<HeldBatches> held,
             const procgen::v1::Batch& batch);

  const std::shared_ptr<const SharedMapping> mapping_;
  const std::shared_ptr<HeldBatches> held_;
  const int32_t batch_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_SHARED_MAPPING_H_
