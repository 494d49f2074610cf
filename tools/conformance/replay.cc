#include "tools/conformance/replay.h"

#include <cstring>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

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
                         const std::vector<T>& got) {
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

std::string ComparePictures(const Trace& trace, int32_t step, const Observations& observed) {
  std::vector<uint32_t> digests(static_cast<size_t>(trace.env_count));
  const size_t bytes = observed.observations.size() / digests.size();
  for (size_t i = 0; i < digests.size(); ++i) {
    digests[i] = ObservationDigest(observed.observations.data() + i * bytes, bytes);
  }
  return CompareField(step, "observation_fnv1a", trace.observation_digests, digests);
}

std::string Compare(const Trace& trace, int32_t step, const Observations& observed,
                    bool with_pictures) {
  for (const std::string& difference :
       {CompareField(step, "reward", trace.rewards, observed.rewards),
        CompareField(step, "first", trace.first, observed.first),
        CompareField(step, "level_seed", trace.level_seeds, observed.level_seeds),
        CompareField(step, "prev_level_seed", trace.prev_level_seeds, observed.prev_level_seeds),
        CompareField(step, "prev_level_complete", trace.prev_level_complete,
                     observed.prev_level_complete)}) {
    if (!difference.empty()) {
      return difference;
    }
  }
  return with_pictures ? ComparePictures(trace, step, observed) : "";
}

}  // namespace

std::string FirstDifference(const Trace& trace, Player& player, bool with_pictures) {
  Observations observed;
  absl::Status status = player.Observe(&observed);
  const absl::Span<const int32_t> actions = trace.actions;
  const auto row = static_cast<size_t>(trace.env_count);
  for (int32_t step = 0; status.ok(); ++step) {
    std::string difference = Compare(trace, step, observed, with_pictures);
    if (!difference.empty() || step == trace.step_count) {
      return difference;
    }
    status = player.Step(actions.subspan(static_cast<size_t>(step) * row, row), &observed);
  }
  return status.ToString();
}

}  // namespace procgen
