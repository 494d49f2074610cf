#include "envcore/pool/observation_format.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace procgen {

std::vector<int32_t> ObservationFormat::Shape() const {
  std::vector<int32_t> shape;
  if (frame_stack > 1) {
    shape.push_back(frame_stack);
  }
  if (frame.layout == Layout::kChw) {
    shape.push_back(frame.channels());
  }
  shape.insert(shape.end(), {frame.size_px, frame.size_px});
  if (frame.layout == Layout::kHwc) {
    shape.push_back(frame.channels());
  }
  return shape;
}

Status CheckObservationFormat(const ObservationFormat& format) {
  struct Field {
    absl::string_view name;
    int32_t value;
    int32_t min;
    int32_t max;
  };
  for (const Field& field :
       {Field{"frame.size_px", format.frame.size_px, kObservationSizePxMin, kObservationSizePxMax},
        Field{"frame.color", static_cast<int32_t>(format.frame.color),
              static_cast<int32_t>(Color::kRgb), static_cast<int32_t>(kColorMax)},
        Field{"frame.layout", static_cast<int32_t>(format.frame.layout),
              static_cast<int32_t>(Layout::kHwc), static_cast<int32_t>(Layout::kChw)},
        Field{"frame_stack", format.frame_stack, 1, kFrameStackMax}}) {
    if (field.value < field.min || field.value > field.max) {
      return InvalidArgumentError(absl::StrCat("observation_format.", field.name, " is ",
                                               field.value, ", must be in [", field.min, ", ",
                                               field.max, "]"));
    }
  }
  return OkStatus();
}

}  // namespace procgen
