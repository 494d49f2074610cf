#include "server/encoding/observation_encoder.h"

#include <algorithm>
#include <functional>

#include "server/encoding/check.h"

namespace procgen {
namespace {

// Higher levels save few bytes and take much longer (README.md).
constexpr int kZstdLevel = 1;
// Upper bound of what ZSTD_compressBound adds to the size of a small input.
constexpr int64_t kZstdOverheadBytes = 128;

}  // namespace

ObservationEncoder::ObservationEncoder(int32_t env_count, size_t observation_bytes)
    : observation_bytes_(observation_bytes),
      sent_(static_cast<size_t>(env_count) * observation_bytes),
      zstd_(ZSTD_createCCtx()) {
  Check(zstd_ != nullptr, "no memory for zstd");
}

std::string ObservationEncoder::Encode(int32_t first, int32_t count,
                                       absl::Span<const uint8_t> observations) {
  const size_t size = static_cast<size_t>(count) * observation_bytes_;
  Check(observations.size() == size, "observations have another size");
  uint8_t* const sent = sent_.data() + static_cast<size_t>(first) * observation_bytes_;
  differences_.resize(size);
  // Not indexed through the members, which bytes may alias, so that the loops become SIMD.
  std::transform(observations.begin(), observations.end(), sent, differences_.begin(),
                 std::minus<>());
  std::copy(observations.begin(), observations.end(), sent);
  std::string frame(ZSTD_compressBound(size), '\0');
  const size_t frame_size = ZSTD_compressCCtx(zstd_.get(), frame.data(), frame.size(),
                                              differences_.data(), size, kZstdLevel);
  Check(ZSTD_isError(frame_size) == 0, "zstd cannot compress");
  frame.resize(frame_size);
  return frame;
}

int64_t EncodedBytesMax(Encoding encoding, int64_t observation_bytes) {
  return encoding == Encoding::kRaw
             ? observation_bytes
             : observation_bytes + observation_bytes / 256 + kZstdOverheadBytes;
}

}  // namespace procgen
