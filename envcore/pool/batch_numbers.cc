#include "envcore/pool/batch_numbers.h"

#include <cstddef>

#include "absl/types/span.h"

namespace procgen {
namespace {

template <typename Number>
void Lend(std::vector<Number>* memory, size_t count, absl::Span<Number>* span) {
  if (span->empty()) {
    memory->resize(count);
    *span = absl::MakeSpan(*memory);
  }
}

}  // namespace

Batch BatchNumbers::ReplaceEmptyArrays(Batch batch, int32_t count) {
  const auto rows = static_cast<size_t>(count);
  Lend(&rewards, rows, &batch.rewards);
  Lend(&first, rows, &batch.first);
  Lend(&terminated, rows, &batch.terminated);
  Lend(&truncated, rows, &batch.truncated);
  Lend(&level_seeds, rows, &batch.level_seeds);
  Lend(&prev_level_seeds, rows, &batch.prev_level_seeds);
  Lend(&prev_level_complete, rows, &batch.prev_level_complete);
  Lend(&episode_returns, rows, &batch.episode_returns);
  Lend(&episode_lengths, rows, &batch.episode_lengths);
  Lend(&fingerprints, rows, &batch.fingerprints);
  return batch;
}

}  // namespace procgen
