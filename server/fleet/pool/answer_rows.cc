#include "server/fleet/pool/answer_rows.h"

#include <cstring>

#include "absl/types/span.h"

namespace procgen {
namespace {

template <typename Element, typename Source>
void CopySpan(absl::Span<const Source> from, size_t from_row, absl::Span<Element> to, size_t to_row,
              size_t rows, size_t row_size = 1) {
  static_assert(sizeof(Element) == sizeof(Source));
  if (!to.empty() && !from.empty()) {
    std::memcpy(to.data() + to_row * row_size, from.data() + from_row * row_size,
                rows * row_size * sizeof(Element));
  }
}

}  // namespace

void CopyAnswerRows(const procgen_client::Batch& answer, size_t answer_row, const Batch& batch,
                    size_t batch_row, size_t row_count, size_t observation_bytes) {
  const size_t from = answer_row;
  const size_t to = batch_row;
  CopySpan(answer.observations(), from, batch.observations, to, row_count, observation_bytes);
  CopySpan(answer.rewards(), from, batch.rewards, to, row_count);
  CopySpan(answer.first(), from, batch.first, to, row_count);
  CopySpan(answer.terminated(), from, batch.terminated, to, row_count);
  CopySpan(answer.truncated(), from, batch.truncated, to, row_count);
  CopySpan(answer.level_seeds(), from, batch.level_seeds, to, row_count);
  CopySpan(answer.prev_level_seeds(), from, batch.prev_level_seeds, to, row_count);
  CopySpan(answer.prev_level_complete(), from, batch.prev_level_complete, to, row_count);
  CopySpan(answer.episode_returns(), from, batch.episode_returns, to, row_count);
  CopySpan(answer.episode_lengths(), from, batch.episode_lengths, to, row_count);
  // Rows of ended episodes are stored contiguously.
  size_t ended_count = 0;
  for (size_t row = 0; row < from + row_count; ++row) {
    if (!answer.terminated()[row] && !answer.truncated()[row]) {
      continue;
    }
    if (row >= from) {
      CopySpan(answer.fingerprints(), ended_count, batch.fingerprints, to + row - from, 1);
      CopySpan(answer.final_observations(), ended_count, batch.final_observations, to + row - from,
               1, observation_bytes);
    }
    ++ended_count;
  }
}

}  // namespace procgen
