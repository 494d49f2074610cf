#ifndef CLIENTS_PYTHON_NATIVE_NATIVE_BATCH_H_
#define CLIENTS_PYTHON_NATIVE_NATIVE_BATCH_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/types/span.h"
#include "procgen_client/batch.h"
#include "pybind11/numpy.h"
#include "pybind11/pybind11.h"

namespace procgen_python {

// A free list of batches to receive into. Reuses their memory, mainly that of decoded observations.
// Threads: any method from any thread.
class BatchReserve {
 public:
  std::unique_ptr<procgen_client::Batch> Take();
  void PutBack(std::unique_ptr<procgen_client::Batch> batch);

 private:
  absl::Mutex mutex_;
  std::vector<std::unique_ptr<procgen_client::Batch>> batches_ ABSL_GUARDED_BY(mutex_);
};

// The memory of observation arrays. While an array refers to it, a batch of shared memory is held
// and a received batch is not reused.
class ObservationMemory {
 public:
  ObservationMemory(std::unique_ptr<procgen_client::Batch> batch,
                    std::shared_ptr<BatchReserve> reserve);
  ~ObservationMemory();
  ObservationMemory(const ObservationMemory&) = delete;
  ObservationMemory& operator=(const ObservationMemory&) = delete;

  const procgen_client::Batch& batch() const { return *batch_; }

 private:
  std::unique_ptr<procgen_client::Batch> batch_;
  const std::shared_ptr<BatchReserve> reserve_;
};

// An answer, which makes its arrays on request. Numbers are copied, so that they do not keep
// observations alive; observations are borrowed.
class NativeBatch {
 public:
  // `shape`: of one observation. `is_shared`: the observations are in shared memory, so their
  // arrays are read-only.
  NativeBatch(std::unique_ptr<procgen_client::Batch> batch, std::shared_ptr<BatchReserve> reserve,
              std::shared_ptr<const std::vector<pybind11::ssize_t>> shape, bool is_shared);

  int64_t sequence_number() const { return sequence_number_; }
  int32_t first_env() const { return first_env_; }
  // Returns a new array with this name; None: observations that were not requested. Raises
  // AttributeError: there is no such array.
  pybind11::object Array(const std::string& name) const;

 private:
  static constexpr size_t kNumberArrayCount = 10;
  // Copies numbers to the end of numbers_.
  template <typename Number>
  void Keep(size_t index, absl::Span<const Number> numbers);
  pybind11::object Observations(absl::Span<const uint8_t> bytes) const;

  int64_t sequence_number_;
  int32_t first_env_;
  std::vector<uint64_t> numbers_;  // all number arrays, concatenated
  struct Place {
    size_t offset = 0;  // in numbers_
    size_t count = 0;   // elements
  };
  std::array<Place, kNumberArrayCount> places_;
  std::shared_ptr<ObservationMemory> memory_;  // null: no observations
  std::shared_ptr<const std::vector<pybind11::ssize_t>> shape_;
  bool is_shared_;
};

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_NATIVE_BATCH_H_
