#ifndef SERVER_ENCODING_ENCODING_H_
#define SERVER_ENCODING_ENCODING_H_

namespace procgen {

// How a pool's observations are sent: as they are drawn, or as differences compressed with zstd
// (Encoding in proto/procgen/v1/pools.proto).
enum class Encoding { kRaw, kDeltaZstd };

}  // namespace procgen

#endif  // SERVER_ENCODING_ENCODING_H_
