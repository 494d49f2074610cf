// libFuzzer's mutator for snapshots: mostly changes the tree of fields, sometimes bytes of the
// body, rarely the header. Random changes alone would hardly ever pass the checksum.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"
#include "envcore/state/snapshot_frame.h"
#include "tests/fuzz/snapshot_mutation.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* bytes, size_t size, size_t size_max);

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* bytes, size_t size, size_t size_max,
                                          unsigned int seed) {
  constexpr unsigned int kHeaderTurn = 64;  // one mutation in this many
  constexpr unsigned int kBodyTurn = 8;
  using procgen::kSnapshotHeaderBytes;
  std::string changed;
  if (seed % kBodyTurn != 0) {
    const absl::string_view snapshot(reinterpret_cast<const char*>(bytes), size);
    changed = procgen::MutatedSnapshot(snapshot, seed, size_max);
  }
  if (changed.empty()) {
    const bool has_body = size > kSnapshotHeaderBytes && size_max > kSnapshotHeaderBytes;
    if (!has_body || seed % kHeaderTurn == 0) {
      return LLVMFuzzerMutate(bytes, size, size_max);
    }
    uint8_t* const body = bytes + kSnapshotHeaderBytes;
    const size_t body_size =
        LLVMFuzzerMutate(body, size - kSnapshotHeaderBytes, size_max - kSnapshotHeaderBytes);
    changed = procgen::FrameSnapshot({reinterpret_cast<const char*>(body), body_size});
  }
  std::copy(changed.begin(), changed.end(), bytes);
  return changed.size();
}
