#ifndef SERVER_POOL_EPISODES_ANNOTATION_RECORDING_H_
#define SERVER_POOL_EPISODES_ANNOTATION_RECORDING_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// Values of one kind for one step of an environment.
struct StepAnnotation {
  absl::string_view name;
  absl::Span<const float> values;  // [k]
};

// Annotations of one name over the steps of an episode.
struct AnnotationSeries {
  std::string name;
  int32_t value_count = 0;    // k
  int32_t first_step = 0;     // the step of the first row
  std::vector<float> values;  // [T, k]; NaN in a step without this annotation
};

// Annotations of the steps of an episode that is being recorded. Threads: compatible.
class AnnotationRecording {
 public:
  // Number of series; steps with further names are recorded without them.
  static constexpr size_t kSeriesMax = 32;

  // Memory that it holds, and that Add would hold in addition.
  int64_t bytes() const { return bytes_; }
  int64_t GrowthBytes(int32_t step, absl::Span<const StepAnnotation> annotations) const;

  // Adds the annotations of a step, which is later than those before.
  void Add(int32_t step, absl::Span<const StepAnnotation> annotations);
  // Drops all rows and the series that had none; keeps the memory of the others.
  void ClearRows();
  // Drops everything.
  void Clear();
  // Frees memory beyond that of the rows, such as that of a copied recording.
  void ShrinkToFit();
  // Drops the older half of the rows, with their memory.
  void DropOlderHalf();

  // The series that have rows.
  std::vector<AnnotationSeries> Read() const;

 private:
  const AnnotationSeries* Find(const StepAnnotation& annotation) const;
  // The number of values that a series needs room for, to add `annotation`.
  static size_t SizeAfter(const AnnotationSeries& series, int32_t step);
  void UpdateBytes();

  std::vector<AnnotationSeries> series_;
  int64_t bytes_ = 0;
};

}  // namespace procgen

#endif  // SERVER_POOL_EPISODES_ANNOTATION_RECORDING_H_
