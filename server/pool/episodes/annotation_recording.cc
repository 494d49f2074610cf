#include "server/pool/episodes/annotation_recording.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>

namespace procgen {
namespace {

// Rows of a new series. A full one is doubled.
constexpr size_t kRowsMin = 16;

int64_t BytesOf(size_t capacity) {
  return static_cast<int64_t>(sizeof(AnnotationSeries) + capacity * sizeof(float));
}

// The capacity of a series of k values that needs room for `size`.
size_t CapacityFor(size_t size, size_t capacity, size_t value_count) {
  return size <= capacity ? capacity : std::max({size, 2 * capacity, kRowsMin * value_count});
}

}  // namespace

const AnnotationSeries* AnnotationRecording::Find(const StepAnnotation& annotation) const {
  const auto found = std::find_if(
      series_.begin(), series_.end(),
      [&annotation](const AnnotationSeries& series) { return series.name == annotation.name; });
  return found == series_.end() ? nullptr : &*found;
}

size_t AnnotationRecording::SizeAfter(const AnnotationSeries& series, int32_t step) {
  const int32_t rows = series.values.empty() ? 1 : step - series.first_step + 1;
  return static_cast<size_t>(rows) * static_cast<size_t>(series.value_count);
}

int64_t AnnotationRecording::GrowthBytes(int32_t step,
                                         absl::Span<const StepAnnotation> annotations) const {
  int64_t growth = 0;
  for (const StepAnnotation& annotation : annotations) {
    const size_t value_count = annotation.values.size();
    const AnnotationSeries* const series = Find(annotation);
    if (series == nullptr) {
      growth += BytesOf(CapacityFor(value_count, 0, value_count));
      continue;
    }
    const bool continues = static_cast<size_t>(series->value_count) == value_count;
    const size_t size = continues ? SizeAfter(*series, step) : value_count;
    const size_t capacity = series->values.capacity();
    growth += BytesOf(CapacityFor(size, capacity, value_count)) - BytesOf(capacity);
  }
  return growth;
}

void AnnotationRecording::Add(int32_t step, absl::Span<const StepAnnotation> annotations) {
  for (const StepAnnotation& annotation : annotations) {
    auto* series = const_cast<AnnotationSeries*>(Find(annotation));
    if (series == nullptr) {
      if (series_.size() == kSeriesMax) {
        continue;
      }
      series = &series_.emplace_back();
      series->name.assign(annotation.name.data(), annotation.name.size());
    }
    std::vector<float>& values = series->values;
    const auto value_count = static_cast<int32_t>(annotation.values.size());
    if (series->value_count != value_count) {
      values.clear();
      series->value_count = value_count;
    }
    if (values.empty()) {
      series->first_step = step;
    }
    const size_t size = SizeAfter(*series, step);
    values.reserve(CapacityFor(size, values.capacity(), annotation.values.size()));
    values.resize(size - annotation.values.size(), std::numeric_limits<float>::quiet_NaN());
    values.insert(values.end(), annotation.values.begin(), annotation.values.end());
  }
  UpdateBytes();
}

void AnnotationRecording::ClearRows() {
  std::erase_if(series_, [](const AnnotationSeries& series) { return series.values.empty(); });
  for (AnnotationSeries& series : series_) {
    series.values.clear();
  }
  UpdateBytes();
}

void AnnotationRecording::Clear() {
  series_.clear();
  series_.shrink_to_fit();
  bytes_ = 0;
}

void AnnotationRecording::ShrinkToFit() {
  std::erase_if(series_, [](const AnnotationSeries& series) { return series.values.empty(); });
  for (AnnotationSeries& series : series_) {
    series.values.shrink_to_fit();
  }
  UpdateBytes();
}

void AnnotationRecording::DropOlderHalf() {
  for (AnnotationSeries& series : series_) {
    const size_t rows = series.values.size() / static_cast<size_t>(series.value_count);
    const size_t dropped = (rows + 1) / 2;
    series.values = std::vector<float>(
        series.values.begin() +
            static_cast<std::ptrdiff_t>(dropped * static_cast<size_t>(series.value_count)),
        series.values.end());
    series.first_step += static_cast<int32_t>(dropped);
  }
  std::erase_if(series_, [](const AnnotationSeries& series) { return series.values.empty(); });
  UpdateBytes();
}

std::vector<AnnotationSeries> AnnotationRecording::Read() const {
  std::vector<AnnotationSeries> read;
  std::copy_if(series_.begin(), series_.end(), std::back_inserter(read),
               [](const AnnotationSeries& series) { return !series.values.empty(); });
  return read;
}

void AnnotationRecording::UpdateBytes() {
  bytes_ = 0;
  for (const AnnotationSeries& series : series_) {
    bytes_ += BytesOf(series.values.capacity());
  }
}

}  // namespace procgen
