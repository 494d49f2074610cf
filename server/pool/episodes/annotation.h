#ifndef SERVER_POOL_EPISODES_ANNOTATION_H_
#define SERVER_POOL_EPISODES_ANNOTATION_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// Limits of the annotations of a step: their number, the length of a name, and the number of values
// for one environment. A saliency map may have as many as the default observation has pixels. It is
// recorded with fewer: a map of 64 x 64 as the means of blocks of 4 x 4.
inline constexpr size_t kAnnotationCountMax = 16;
inline constexpr size_t kAnnotationNameBytesMax = 64;
inline constexpr size_t kAnnotationValuesMax = 64;
inline constexpr absl::string_view kSaliencyName = "saliency";
inline constexpr size_t kSaliencyValuesMax = 64 * 64;
inline constexpr size_t kSaliencyRecordedMax = 16 * 16;

// Values that a learner sends with a step, for viewers. They do not change the step.
struct Annotation {
  absl::string_view name;
  absl::Span<const float> values;  // [n, k], environment first; n: those of the slice
};

// The values of one environment.
struct EnvironmentAnnotation {
  std::string name;
  std::vector<float> values;  // [k]
};

// Checks the annotations of a step of `env_count` environments, at least 1. Errors:
// INVALID_ARGUMENT; the message gives the value and the allowed values.
absl::Status CheckAnnotations(absl::Span<const Annotation> annotations, int32_t env_count);

// Copies the values of row `row` of `env_count` to `copies`, whose memory is reused.
// REQUIRES: CheckAnnotations returned OK.
void CopyAnnotations(absl::Span<const Annotation> annotations, int32_t env_count, size_t row,
                     std::vector<EnvironmentAnnotation>* copies);

}  // namespace procgen

#endif  // SERVER_POOL_EPISODES_ANNOTATION_H_
