#include "envcore/pool/pool_input.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace procgen {
namespace {

Status CheckSpan(absl::string_view name, size_t size, size_t rows, size_t values_per_row) {
  if (size != 0 && size != rows * values_per_row) {
    return InvalidArgumentError(absl::StrCat("the batch's ", name, " have ", size,
                                             " values, must have ", rows * values_per_row,
                                             " or none"));
  }
  return OkStatus();
}

Status CheckBatch(const Batch& batch, size_t rows, size_t observation_bytes) {
#define PROCGEN_CHECK(type, name, member) CheckSpan(#name, batch.name.size(), rows, 1),
  for (const Status& status :
       {PROCGEN_BATCH_NUMBERS(PROCGEN_CHECK)
            CheckSpan("observations", batch.observations.size(), rows, observation_bytes),
        CheckSpan("final_observations", batch.final_observations.size(), rows,
                  observation_bytes)}) {
#undef PROCGEN_CHECK
    if (!status.ok()) {
      return status;
    }
  }
  return OkStatus();
}

Status CheckActions(const StepInput& input) {
  const size_t expected = input.steps ? static_cast<size_t>(input.count) : 0;
  if (input.actions.size() != expected) {
    return InvalidArgumentError(absl::StrCat("actions has ", input.actions.size(),
                                             " entries, the slice has ", expected,
                                             " environments to step"));
  }
  for (size_t i = 0; i < input.actions.size(); ++i) {
    if (input.actions[i] < kEndEpisodeAction || input.actions[i] >= kActionCount) {
      return InvalidArgumentError(absl::StrCat(
          "action ", input.actions[i], " of environment ", input.first + static_cast<int32_t>(i),
          " is not in [", kEndEpisodeAction, ", ", kActionCount - 1, "]"));
    }
  }
  if (input.repeat < 1 || input.repeat > kRepeatMax) {
    return InvalidArgumentError(
        absl::StrCat("repeat is ", input.repeat, ", must be in [1, ", kRepeatMax, "]"));
  }
  return OkStatus();
}

// Checks that the entries of a sparse list name environments of the slice, each at most once.
template <typename Entry>
Status CheckSparse(absl::string_view name, absl::Span<const Entry> entries,
                   const StepInput& input) {
  std::vector<bool> had;
  if (!entries.empty()) {
    had.resize(static_cast<size_t>(input.count));
  }
  for (const Entry& entry : entries) {
    const int64_t row = int64_t{entry.environment} - input.first;
    if (row < 0 || row >= input.count) {
      return InvalidArgumentError(absl::StrCat(name, " names environment ", entry.environment,
                                               ", the slice is [", input.first, ", ",
                                               input.first + input.count, ")"));
    }
    if (had[static_cast<size_t>(row)]) {
      return InvalidArgumentError(
          absl::StrCat(name, " names environment ", entry.environment, " twice"));
    }
    had[static_cast<size_t>(row)] = true;
  }
  return OkStatus();
}

}  // namespace

Status CheckPoolOptions(const PoolOptions& options) {
  if (options.games.empty()) {
    return InvalidArgumentError("games is empty, must name at least one game");
  }
  if (options.env_count < 1) {
    return InvalidArgumentError(
        absl::StrCat("env_count is ", options.env_count, ", must be at least 1"));
  }
  if (options.first_env < 0) {
    return InvalidArgumentError(
        absl::StrCat("first_env is ", options.first_env, ", must be at least 0"));
  }
  const int64_t end = int64_t{options.first_env} + options.env_count;
  const int64_t total = options.total_env_count == 0 ? end : options.total_env_count;
  if (total < end) {
    return InvalidArgumentError(absl::StrCat("total_env_count is ", options.total_env_count,
                                             ", must be at least first_env + env_count = ", end,
                                             ", or 0"));
  }
  if (total > kTotalEnvCountMax) {
    return InvalidArgumentError(absl::StrCat("the whole pool has ", total,
                                             " environments, must be at most ", kTotalEnvCountMax));
  }
  const auto game_count = static_cast<int64_t>(options.games.size());
  if (total % game_count != 0) {
    return InvalidArgumentError(absl::StrCat("there are ", total, " environments for ", game_count,
                                             " games, must be a multiple of the number of games"));
  }
  return CheckObservationFormat(options.observation_format);
}

Status CheckStep(const StepInput& input, const Batch& batch, int32_t env_count,
                 size_t observation_bytes) {
  if (input.first < 0 || input.count < 1 || int64_t{input.first} + input.count > env_count) {
    return InvalidArgumentError(absl::StrCat("the slice is ", input.count, " environments from ",
                                             input.first, ", the pool has ", env_count));
  }
  for (const Status& status :
       {CheckActions(input), CheckSparse("next_levels", input.next_levels, input),
        CheckSparse("resets", input.resets, input),
        CheckBatch(batch, static_cast<size_t>(input.count), observation_bytes)}) {
    if (!status.ok()) {
      return status;
    }
  }
  return OkStatus();
}

}  // namespace procgen
