#include "procgen_client/run/step_part.h"

namespace procgen_client {
namespace {

template <typename Element>
absl::Span<Element> Rows(absl::Span<Element> array, int32_t first, int32_t count, size_t row_size) {
  return array.empty() ? array
                       : array.subspan(static_cast<size_t>(first) * row_size,
                                       static_cast<size_t>(count) * row_size);
}

template <typename Element>
std::vector<Element> InSlice(absl::Span<const Element> list, int32_t first, int32_t count) {
  std::vector<Element> part;
  for (const Element& element : list) {
    if (element.environment >= first && element.environment < first + count) {
      part.push_back(element);
    }
  }
  return part;
}

}  // namespace

StepPart::StepPart(const procgen::StepInput& whole, absl::Span<const Annotation> whole_annotations,
                   const procgen::Batch& whole_batch, int32_t begin, int32_t count,
                   size_t observation_bytes)
    : next_levels(InSlice(whole.next_levels, whole.first + begin, count)),
      resets(InSlice(whole.resets, whole.first + begin, count)),
      input(whole) {
  input.first = whole.first + begin;
  input.count = count;
  input.actions = Rows(whole.actions, begin, count, 1);
  input.next_levels = next_levels;
  input.resets = resets;
  for (const Annotation& annotation : whole_annotations) {
    const size_t row_size = annotation.values.size() / static_cast<size_t>(whole.count);
    annotations.push_back({annotation.name, Rows(annotation.values, begin, count, row_size)});
  }
  const auto rows = [&](auto array, size_t row_size) {
    return Rows(array, begin, count, row_size);
  };
  batch.observations = rows(whole_batch.observations, observation_bytes);
#define PROCGEN_ROWS(type, name, member) batch.name = rows(whole_batch.name, 1);
  PROCGEN_BATCH_NUMBERS(PROCGEN_ROWS)
#undef PROCGEN_ROWS
  batch.final_observations = rows(whole_batch.final_observations, observation_bytes);
}

void StepPart::RenumberFrom(int32_t first) {
  input.first -= first;
  for (procgen::NextLevel& next : next_levels) {
    next.environment -= first;
  }
  for (procgen::Reset& reset : resets) {
    reset.environment -= first;
  }
}

}  // namespace procgen_client
