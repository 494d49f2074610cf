#include "server/session/backend/observation_coding.h"

namespace procgen {

PictureShape ShapeOf(const ObservationFormat& format) {
  const bool planes = format.frame.layout == Layout::kChw;
  const int32_t channels = format.frame.channels();
  return {.rows = format.frame.size_px * format.frame_stack * (planes ? channels : 1),
          .columns = format.frame.size_px,
          .pixel_bytes = planes ? 1 : channels,
          .stack = format.frame_stack};
}

ObservationCoding::ObservationCoding(const ObservationFormat& format, Encoding encoding)
    : encoding_(encoding),
      shape_(ShapeOf(format)),
      drawn_bytes_(static_cast<int64_t>(format.bytes())),
      sent_bytes_max_(encoding == Encoding::kRaw
                          ? drawn_bytes_
                          : static_cast<int64_t>(ObservationEncoder::EncodedBytesMax(shape_))) {}

std::unique_ptr<ObservationEncoder> ObservationCoding::MakeEncoder(int32_t env_count) const {
  if (encoding_ == Encoding::kRaw) {
    return nullptr;
  }
  return std::make_unique<ObservationEncoder>(shape_, env_count);
}

}  // namespace procgen
