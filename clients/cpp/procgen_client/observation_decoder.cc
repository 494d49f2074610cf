#include "procgen_client/observation_decoder.h"

#include "absl/strings/str_cat.h"
#include "zstd.h"

namespace procgen_client {

absl::Status ObservationDecoder::Decode(int32_t first, int32_t count, absl::string_view encoded,
                                        absl::Span<uint8_t> observations) {
  const size_t size =
      ZSTD_decompress(observations.data(), observations.size(), encoded.data(), encoded.size());
  if (ZSTD_isError(size) != 0 || size != observations.size()) {
    return absl::DataLossError(
        absl::StrCat("the observations of ", count, " environments cannot be decoded: ",
                     ZSTD_isError(size) != 0 ? ZSTD_getErrorName(size) : "they are too short"));
  }
  uint8_t* const received = received_.data() + static_cast<size_t>(first) * observation_bytes_;
  for (size_t i = 0; i < size; ++i) {
    received[i] = static_cast<uint8_t>(received[i] + observations[i]);
    observations[i] = received[i];
  }
  return absl::OkStatus();
}

}  // namespace procgen_client
