#ifndef ENVCORE_STATE_SNAPSHOT_FRAME_H_
#define ENVCORE_STATE_SNAPSHOT_FRAME_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"
#include "envcore/status/status.h"

namespace procgen {

// The header of a snapshot. All numbers are unsigned, little-endian, 32 bits.
//
//   byte 0   magic: "PGST"
//        4   version: kSnapshotVersion
//        8   length of the body in bytes
//       12   CRC-32 (as in zlib and PNG) of the body
//       16   the body
//
// The version changes when the meaning of the body changes. A reader supports one version only.
inline constexpr absl::string_view kSnapshotMagic = "PGST";
inline constexpr uint32_t kSnapshotVersion = 1;
inline constexpr size_t kSnapshotHeaderBytes = 16;
// Largest size of a snapshot, header included. Snapshots of the games have 1 to 12 kB after 300
// random steps.
inline constexpr size_t kSnapshotBytesMax = size_t{1} << 20;

// Returns `body` with a header. REQUIRES: the result has at most kSnapshotBytesMax bytes.
std::string FrameSnapshot(absl::string_view body);

// Returns the body of `snapshot`, as a view into it. Errors: DATA_LOSS: the bytes are truncated,
// too long, not a snapshot, of another version or corrupted.
StatusOr<absl::string_view> UnframeSnapshot(absl::string_view snapshot);

// Returns the CRC-32 of the body of `snapshot`, as its header has it. REQUIRES: a valid snapshot.
uint32_t SnapshotChecksum(absl::string_view snapshot);

}  // namespace procgen

#endif  // ENVCORE_STATE_SNAPSHOT_FRAME_H_
