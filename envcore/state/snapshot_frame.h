#ifndef ENVCORE_STATE_SNAPSHOT_FRAME_H_
#define ENVCORE_STATE_SNAPSHOT_FRAME_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen {

// The bytes around a snapshot's body. All numbers are unsigned, little-endian, 32 bits.
//
//   byte 0   magic: "PGST"
//        4   version: kSnapshotVersion
//        8   length of the body in bytes
//       12   CRC-32 (that of zlib and PNG) of the body
//       16   the body
//
// The version changes with the meaning of the body: a reader knows one version and no other.
inline constexpr absl::string_view kSnapshotMagic = "PGST";
inline constexpr uint32_t kSnapshotVersion = 1;
inline constexpr size_t kSnapshotHeaderBytes = 16;
// The longest snapshot, header included. Those of the games had 1 to 12 kB after 300 random steps.
inline constexpr size_t kSnapshotBytesMax = size_t{1} << 20;

// `body` with its header before it. REQUIRES: it is no longer than a snapshot can be.
std::string FrameSnapshot(absl::string_view body);

// The body in `snapshot`, whose memory it shares. Errors: DATA_LOSS whatever is wrong with the
// bytes: cut off, too long, no snapshot at all, of another version, or changed on the way.
absl::StatusOr<absl::string_view> UnframeSnapshot(absl::string_view snapshot);

}  // namespace procgen

#endif  // ENVCORE_STATE_SNAPSHOT_FRAME_H_
