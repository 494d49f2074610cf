// Fuzz target: the C++ client reads bytes as a RunPoolResponse with a batch into the caller's
// memory, as raw or as encoded observations. An input is one byte (bit 0: encoded) and the message.
// Aborts if memory beside the caller's arrays changes, or if an error has an undocumented code.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "grpcpp/support/byte_buffer.h"
#include "procgen_client/observation_decoder.h"
#include "procgen_client/run/batch_reader.h"

namespace procgen {
namespace {

// The pool of the batch, small so that inputs are.
constexpr int32_t kFuzzedEnvCount = 3;
constexpr size_t kFuzzedObservationBytes = 16 * 16 * 3;

constexpr size_t kGuardRows = 64;
constexpr uint8_t kGuard = 0xa5;

void Require(bool holds, absl::string_view claim, const absl::Status& status) {
  if (!holds) {
    std::cerr << "batch_fuzz: " << claim << ": " << status << std::endl;
    std::abort();
  }
}

// An array of the caller between two guards. `row_size`: numbers in a row.
template <typename Number>
class GuardedArray {
 public:
  explicit GuardedArray(size_t row_size = 1)
      : bytes_((2 * kGuardRows + kFuzzedEnvCount) * row_size * sizeof(Number), kGuard),
        begin_(kGuardRows * row_size),
        size_(kFuzzedEnvCount * row_size) {}

  absl::Span<Number> span() { return {reinterpret_cast<Number*>(bytes_.data()) + begin_, size_}; }

  void Check() const {
    const auto is_guard = [](uint8_t byte) { return byte == kGuard; };
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(begin_ * sizeof(Number));
    const auto end = begin + static_cast<std::ptrdiff_t>(size_ * sizeof(Number));
    Require(
        std::all_of(bytes_.begin(), begin, is_guard) && std::all_of(end, bytes_.end(), is_guard),
        "only the caller's arrays are written", absl::OkStatus());
  }

 private:
  std::vector<uint8_t> bytes_;
  size_t begin_;
  size_t size_;
};

void Read(bool is_encoded, absl::Span<const uint8_t> message) {
  GuardedArray<uint8_t> observations(kFuzzedObservationBytes);
  GuardedArray<uint8_t> finals(kFuzzedObservationBytes);
  GuardedArray<float> rewards;
  GuardedArray<float> returns;
  GuardedArray<int32_t> seeds;
  GuardedArray<uint8_t> terminated;
  GuardedArray<uint8_t> truncated;
  GuardedArray<uint64_t> fingerprints;
  Batch batch;
  batch.observations = observations.span();
  batch.final_observations = finals.span();
  batch.rewards = rewards.span();
  batch.episode_returns = returns.span();
  batch.level_seeds = seeds.span();
  batch.terminated = terminated.span();
  batch.truncated = truncated.span();
  batch.fingerprints = fingerprints.span();

  const grpc::Slice slice(message.data(), message.size());
  procgen_client::ObservationDecoder decoder(kFuzzedEnvCount, kFuzzedObservationBytes);
  procgen_client::BatchReader reader;
  const absl::Status status =
      reader.Read(grpc::ByteBuffer(&slice, 1),
                  {.count = kFuzzedEnvCount, .observation_bytes = kFuzzedObservationBytes}, batch,
                  is_encoded ? &decoder : nullptr);
  Require(status.ok() || absl::IsDataLoss(status), "rejected with an undocumented code", status);
  observations.Check();
  finals.Check();
  rewards.Check();
  returns.Check();
  seeds.Check();
  terminated.Check();
  truncated.Check();
  fingerprints.Check();
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  if (size > 0) {
    procgen::Read((bytes[0] & 1) != 0, {bytes + 1, size - 1});
  }
  return 0;
}
