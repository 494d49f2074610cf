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
#define PROCGEN_LEND(type, name, member) \
  Lend(&name, rows, &batch.name);  // NOLINT(bugprone-macro-parentheses)
  PROCGEN_BATCH_NUMBERS(PROCGEN_LEND)
#undef PROCGEN_LEND
  return batch;
}

}  // namespace procgen
