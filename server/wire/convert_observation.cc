#include "server/wire/convert_observation.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "proto/engine_enums.h"
#include "server/wire/enum_value.h"

namespace procgen {
namespace {

constexpr std::pair<v1::Encoding, Encoding> kEncodings[] = {
    {v1::ENCODING_RAW, Encoding::kRaw}, {v1::ENCODING_DELTA_ZSTD, Encoding::kDeltaZstd}};

absl::StatusOr<int32_t> SizePxOf(const v1::ObservationFormat& format) {
  const int32_t size_px = format.size_px() != 0 ? format.size_px() : kObservationSizePx;
  if (size_px < kObservationSizePxMin || size_px > kObservationSizePxMax) {
    return absl::InvalidArgumentError(absl::StrCat("spec.observation_format.size_px is ", size_px,
                                                   ", allowed: 0, or ", kObservationSizePxMin,
                                                   " to ", kObservationSizePxMax));
  }
  return size_px;
}

}  // namespace

absl::StatusOr<ObservationFormat> ObservationFormatOf(const v1::ObservationFormat& message) {
  const absl::StatusOr<Color> color =
      ValueOf(kColors, "spec.observation_format.color", message.color());
  if (!color.ok()) {
    return color.status();
  }
  const absl::StatusOr<Layout> layout =
      ValueOf(kLayouts, "spec.observation_format.layout", message.layout());
  if (!layout.ok()) {
    return layout.status();
  }
  const absl::StatusOr<int32_t> size_px = SizePxOf(message);
  if (!size_px.ok()) {
    return size_px.status();
  }
  if (message.frame_stack() < 0 || message.frame_stack() > kFrameStackMax) {
    return absl::InvalidArgumentError(absl::StrCat("spec.observation_format.frame_stack is ",
                                                   message.frame_stack(), ", allowed: 0 to ",
                                                   kFrameStackMax));
  }
  ObservationFormat format;
  format.frame = {.size_px = *size_px, .color = *color, .layout = *layout};
  format.frame_stack = std::max(message.frame_stack(), 1);
  return format;
}

void FillObservationFormat(const ObservationFormat& format, v1::ObservationFormat* message) {
  message->set_color(EnumOf(kColors, format.frame.color));
  message->set_layout(EnumOf(kLayouts, format.frame.layout));
  message->set_size_px(format.frame.size_px);
  message->set_frame_stack(format.frame_stack);
}

absl::StatusOr<Encoding> EncodingOf(absl::string_view field, v1::Encoding encoding) {
  return ValueOf(kEncodings, field, encoding);
}

v1::Encoding EncodingMessageOf(Encoding encoding) { return EnumOf(kEncodings, encoding); }

}  // namespace procgen
