// Fuzz target: the C++ client decodes bytes as the encoded observations of a batch. Aborts if
// memory beside the caller's changes, or if an error has an undocumented code.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "procgen_client/observation_decoder.h"
#include "tests/fuzz/batch_shape.h"

namespace procgen {
namespace {

constexpr size_t kGuardBytes = 4096;
constexpr uint8_t kGuard = 0xa5;

void Decode(absl::string_view encoded) {
  constexpr size_t kSize = kFuzzedEnvCount * kFuzzedObservationBytes;
  procgen_client::ObservationDecoder decoder(kFuzzedEnvCount, kFuzzedObservationBytes);
  std::vector<uint8_t> memory(kSize + 2 * kGuardBytes, kGuard);
  const absl::Status status = decoder.Decode(0, kFuzzedEnvCount, encoded,
                                             absl::MakeSpan(memory).subspan(kGuardBytes, kSize));
  const auto is_guard = [](uint8_t byte) { return byte == kGuard; };
  if (!(status.ok() || absl::IsDataLoss(status)) ||
      !std::all_of(memory.begin(), memory.begin() + kGuardBytes, is_guard) ||
      !std::all_of(memory.end() - kGuardBytes, memory.end(), is_guard)) {
    std::cerr << "observation_fuzz: another code, or memory beside was written: " << status
              << std::endl;
    std::abort();
  }
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::Decode({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
