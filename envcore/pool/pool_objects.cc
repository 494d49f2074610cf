#include "absl/strings/str_cat.h"
#include "envcore/pool/pool.h"

namespace procgen {
namespace {

// Checks the lengths of the arrays of `count` environments.
Status CheckLengths(int32_t count, int32_t objects_max, size_t row_count, size_t count_count) {
  if (objects_max < 1 || objects_max > kObjectsMax) {
    return InvalidArgumentError(
        absl::StrCat("objects_max is ", objects_max, ", must be in [1, ", kObjectsMax, "]"));
  }
  const size_t wanted = static_cast<size_t>(count) * static_cast<size_t>(objects_max);
  if (row_count != wanted || count_count != static_cast<size_t>(count)) {
    return InvalidArgumentError(absl::StrCat("rows has ", row_count, " and counts ", count_count,
                                             " entries, must have ", wanted, " and ", count));
  }
  return OkStatus();
}

absl::Span<ObjectRow> RowsOf(absl::Span<ObjectRow> rows, size_t index, int32_t objects_max) {
  const auto size = static_cast<size_t>(objects_max);
  return rows.subspan(index * size, size);
}

}  // namespace

Status Pool::ReadObjects(int32_t first, int32_t count, int32_t objects_max,
                         absl::Span<ObjectRow> rows, absl::Span<int32_t> counts) {
  if (first < 0 || count < 1 || count > env_count() - first) {
    return InvalidArgumentError(absl::StrCat("the slice is ", count, " environments from ", first,
                                             " on, the pool has ", env_count()));
  }
  if (Status status = CheckLengths(count, objects_max, rows.size(), counts.size()); !status.ok()) {
    return status;
  }
  if (!Take()) {
    return AbortedError("another call steps or reads this pool; retry when it has returned");
  }
  for (size_t i = 0; i < counts.size(); ++i) {
    counts[i] =
        environments_[static_cast<size_t>(first) + i]->ReadObjects(RowsOf(rows, i, objects_max));
  }
  Release();
  return OkStatus();
}

Status ReadObjectsOf(absl::Span<const std::string> snapshots, int32_t objects_max,
                     absl::Span<ObjectRow> rows, absl::Span<int32_t> counts) {
  if (Status status = CheckLengths(static_cast<int32_t>(snapshots.size()), objects_max, rows.size(),
                                   counts.size());
      !status.ok()) {
    return status;
  }
  for (size_t i = 0; i < snapshots.size(); ++i) {
    const auto environment = Environment::RestoreAny(snapshots[i]);
    if (!environment.ok()) {
      return environment.status();
    }
    counts[i] = (*environment)->ReadObjects(RowsOf(rows, i, objects_max));
  }
  return OkStatus();
}

}  // namespace procgen
