#include "server/session/row_memory.h"

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

Batch RowMemory::LendTo(Batch batch, int32_t count) {
  const auto rows = static_cast<size_t>(count);
  Lend(&rewards_, rows, &batch.rewards);
  Lend(&first_, rows, &batch.first);
  Lend(&terminated_, rows, &batch.terminated);
  Lend(&truncated_, rows, &batch.truncated);
  Lend(&level_seeds_, rows, &batch.level_seeds);
  Lend(&prev_level_seeds_, rows, &batch.prev_level_seeds);
  Lend(&prev_level_complete_, rows, &batch.prev_level_complete);
  Lend(&episode_returns_, rows, &batch.episode_returns);
  Lend(&episode_lengths_, rows, &batch.episode_lengths);
  Lend(&fingerprints_, rows, &batch.fingerprints);
  return batch;
}

}  // namespace procgen
