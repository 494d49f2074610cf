#include "clients/python/native/native_batch.h"

#include <cstring>
#include <utility>

namespace procgen_python {
namespace {

namespace py = pybind11;

// Number of batches whose memory is kept for reuse: requests in flight plus one in use.
constexpr size_t kReserveMax = 4;

// Copies numbers into a new array. The stride is given, because pybind11 before 2.12 reads a wrong
// item size from the dtypes of NumPy 2: 0, so that each element would be the first.
template <typename Number>
py::array MakeArray(py::ssize_t count, const void* numbers) {
  const std::vector<py::ssize_t> strides = {sizeof(Number)};
  return py::array_t<Number>({count}, strides, static_cast<const Number*>(numbers));
}

struct NumberArray {
  const char* name;
  py::array (*make)(py::ssize_t count, const void* numbers);
};

// In the order of NativeBatch::places_.
constexpr NumberArray kNumberArrays[] = {
    {"rewards", MakeArray<float>},
    {"first", MakeArray<bool>},
    {"terminated", MakeArray<bool>},
    {"truncated", MakeArray<bool>},
    {"level_seeds", MakeArray<int32_t>},
    {"prev_level_seeds", MakeArray<int32_t>},
    {"prev_level_complete", MakeArray<bool>},
    {"episode_returns", MakeArray<float>},
    {"episode_lengths", MakeArray<int32_t>},
    {"fingerprints", MakeArray<uint64_t>},
};

}  // namespace

std::unique_ptr<procgen_client::Batch> BatchReserve::Take() {
  absl::MutexLock lock(&mutex_);
  if (batches_.empty()) {
    return std::make_unique<procgen_client::Batch>();
  }
  std::unique_ptr<procgen_client::Batch> batch = std::move(batches_.back());
  batches_.pop_back();
  return batch;
}

void BatchReserve::PutBack(std::unique_ptr<procgen_client::Batch> batch) {
  batch->Release();
  absl::MutexLock lock(&mutex_);
  if (batches_.size() < kReserveMax) {
    batches_.push_back(std::move(batch));
  }
}

ObservationMemory::ObservationMemory(std::unique_ptr<procgen_client::Batch> batch,
                                     std::shared_ptr<BatchReserve> reserve)
    : batch_(std::move(batch)), reserve_(std::move(reserve)) {}

ObservationMemory::~ObservationMemory() { reserve_->PutBack(std::move(batch_)); }

NativeBatch::NativeBatch(std::unique_ptr<procgen_client::Batch> batch,
                         std::shared_ptr<BatchReserve> reserve,
                         std::shared_ptr<const std::vector<py::ssize_t>> shape, bool is_shared)
    : sequence_number_(batch->sequence_number()),
      first_env_(batch->first_env()),
      shape_(std::move(shape)),
      is_shared_(is_shared) {
  // Per row: five arrays of 4 bytes and four of 1; fingerprints have 8.
  constexpr size_t kRowBytes = 24;
  numbers_.reserve(batch->rewards().size() * kRowBytes / sizeof(uint64_t) + kNumberArrayCount +
                   batch->fingerprints().size());
  size_t index = 0;
  Keep(index++, batch->rewards());
  Keep(index++, batch->first());
  Keep(index++, batch->terminated());
  Keep(index++, batch->truncated());
  Keep(index++, batch->level_seeds());
  Keep(index++, batch->prev_level_seeds());
  Keep(index++, batch->prev_level_complete());
  Keep(index++, batch->episode_returns());
  Keep(index++, batch->episode_lengths());
  Keep(index++, batch->fingerprints());
  if (batch->observations().empty() && batch->final_observations().empty()) {
    reserve->PutBack(std::move(batch));
  } else {
    memory_ = std::make_shared<ObservationMemory>(std::move(batch), std::move(reserve));
  }
}

template <typename Number>
void NativeBatch::Keep(size_t index, absl::Span<const Number> numbers) {
  const size_t offset = numbers_.size();
  const size_t bytes = numbers.size() * sizeof(Number);
  numbers_.resize(offset + (bytes + sizeof(uint64_t) - 1) / sizeof(uint64_t));
  if (bytes != 0) {
    std::memcpy(numbers_.data() + offset, numbers.data(), bytes);
  }
  places_[index] = {offset, numbers.size()};
}

py::object NativeBatch::Array(const std::string& name) const {
  if (name == "observations") {
    const bool is_there = memory_ != nullptr && !memory_->batch().observations().empty();
    return is_there ? Observations(memory_->batch().observations()) : py::none();
  }
  if (name == "final_observations") {
    return Observations(memory_ == nullptr ? absl::Span<const uint8_t>()
                                           : memory_->batch().final_observations());
  }
  for (size_t i = 0; i < kNumberArrayCount; ++i) {
    if (name == kNumberArrays[i].name) {
      return kNumberArrays[i].make(static_cast<py::ssize_t>(places_[i].count),
                                   numbers_.data() + places_[i].offset);
    }
  }
  throw py::attribute_error("a batch has no " + name);
}

py::object NativeBatch::Observations(absl::Span<const uint8_t> bytes) const {
  py::ssize_t observation_bytes = 1;
  for (const py::ssize_t length : *shape_) {
    observation_bytes *= length;
  }
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(bytes.size()) / observation_bytes};
  shape.insert(shape.end(), shape_->begin(), shape_->end());
  if (bytes.empty()) {
    return py::array_t<uint8_t>(shape);
  }
  py::array_t<uint8_t> array(shape, bytes.data(), py::cast(memory_));
  if (is_shared_) {
    py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  }
  return array;
}

}  // namespace procgen_python
