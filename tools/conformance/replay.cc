#include "tools/conformance/replay.h"

#include <cstring>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "envcore/pool/batch_numbers.h"

namespace procgen {
namespace {

// Steps are numbered from 1; step 0 is before the first step.
std::string Difference(int32_t step, size_t environment, absl::string_view field,
                       absl::string_view expected, absl::string_view got) {
  return absl::StrCat("step ", step, ", environment ", environment, ", ", field, ": expected ",
                      expected, ", got ", got);
}

template <typename T>
std::string CompareField(int32_t step, absl::string_view field, const std::vector<T>& expected_rows,
                         absl::Span<const T> got) {
  const size_t offset = static_cast<size_t>(step) * got.size();
  for (size_t i = 0; i < got.size(); ++i) {
    const T& expected = expected_rows[offset + i];
    // Compares bits, including the sign of zero.
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    if (std::memcmp(&expected, &got[i], sizeof(T)) != 0) {
      return Difference(step, i, field, absl::StrCat(expected), absl::StrCat(got[i]));
    }
  }
  return "";
}

std::string ComparePictures(const Trace& trace, int32_t step, const Batch& batch) {
  std::vector<uint32_t> digests(static_cast<size_t>(trace.env_count));
  for (size_t i = 0; i < digests.size(); ++i) {
    digests[i] = ObservationDigest(&batch.observations[i * kObservationBytes], kObservationBytes);
  }
  return CompareField<uint32_t>(step, "observation_fnv1a", trace.observation_digests, digests);
}

std::string Compare(const Trace& trace, int32_t step, const Batch& batch) {
  for (const std::string& difference :
       {CompareField<float>(step, "reward", trace.rewards, batch.rewards),
        CompareField<uint8_t>(step, "first", trace.first, batch.first),
        CompareField<int32_t>(step, "level_seed", trace.level_seeds, batch.level_seeds),
        CompareField<int32_t>(step, "prev_level_seed", trace.prev_level_seeds,
                              batch.prev_level_seeds),
        CompareField<uint8_t>(step, "prev_level_complete", trace.prev_level_complete,
                              batch.prev_level_complete)}) {
    if (!difference.empty()) {
      return difference;
    }
  }
  return batch.observations.empty() ? "" : ComparePictures(trace, step, batch);
}

}  // namespace

PoolOptions PoolOptionsOf(const Trace& trace) {
  PoolOptions options;
  options.games = trace.games;
  options.env_count = trace.env_count;
  options.environment = trace.options;
  return options;
}

std::string FirstDifference(const Trace& trace, procgen_client::Pool& pool, bool with_pictures) {
  const auto row = static_cast<size_t>(trace.env_count);
  std::vector<uint8_t> observations(with_pictures ? row * kObservationBytes : 0);
  BatchNumbers numbers;
  Batch batch;
  batch.observations = absl::MakeSpan(observations);
  batch = numbers.ReplaceEmptyArrays(batch, trace.env_count);
  StepInput input = {.count = trace.env_count, .steps = false};  // observes
  Status status = pool.Step(input, /*annotations=*/{}, batch);
  const absl::Span<const int32_t> actions = trace.actions;
  input.steps = true;
  for (int32_t step = 0; status.ok(); ++step) {
    std::string difference = Compare(trace, step, batch);
    if (!difference.empty() || step == trace.step_count) {
      return difference;
    }
    input.actions = actions.subspan(static_cast<size_t>(step) * row, row);
    status = pool.Step(input, /*annotations=*/{}, batch);
  }
  return absl::Status(status).ToString();
}

}  // namespace procgen
