#include "server/shared_memory/slot_table.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {

int32_t SlotTable::HeldCount() const {
  return static_cast<int32_t>(std::count_if(entries_.begin(), entries_.end(),
                                            [](const Entry& entry) { return entry.held; }));
}

absl::Status SlotTable::CheckHeld(absl::Span<const int32_t> held) const {
  std::vector<bool> seen(entries_.size(), false);
  for (size_t i = 0; i < held.size(); ++i) {
    const int32_t batch = held[i];
    if (batch < 0 || batch >= batch_count() || seen[static_cast<size_t>(batch)]) {
      return absl::InvalidArgumentError(absl::StrCat(
          "attach.held_batches[", i, "] is ", batch, ", allowed: batches of the pool's shared ",
          "memory, which has ", batch_count(), " of them, each once"));
    }
    seen[static_cast<size_t>(batch)] = true;
  }
  return absl::OkStatus();
}

void SlotTable::BeginStream(absl::Span<const int32_t> held) {
  for (Entry& entry : entries_) {
    entry.held = false;
  }
  for (const int32_t batch : held) {
    entries_[static_cast<size_t>(batch)].held = true;
  }
}

void SlotTable::Grow(int32_t batch_count) {
  entries_.resize(std::max(entries_.size(), static_cast<size_t>(batch_count)));
}

absl::StatusOr<SlotTable::Entries> SlotTable::After(const Change& change) const {
  Entries after = entries_;
  for (size_t i = 0; i < change.released.size(); ++i) {
    const int32_t batch = change.released[i];
    if (batch < 0 || batch >= batch_count() || !after[static_cast<size_t>(batch)].held) {
      return absl::InvalidArgumentError(absl::StrCat(
          "released_batches[", i, "] is ", batch, ", allowed: a batch that the learner holds, once",
          "; it holds ", HeldCount(), " of ", batch_count()));
    }
    after[static_cast<size_t>(batch)].held = false;
  }
  for (Entry& entry : after) {
    entry.kept_for = entry.kept_for <= change.forgotten ? 0 : entry.kept_for;
  }
  return after;
}

absl::Status SlotTable::Apply(const Change& change) {
  absl::StatusOr<Entries> after = After(change);
  if (!after.ok()) {
    return after.status();
  }
  entries_ = *std::move(after);
  return absl::OkStatus();
}

absl::StatusOr<int32_t> SlotTable::Take(const Change& change, int64_t number, bool keeps) {
  absl::StatusOr<Entries> after = After(change);
  if (!after.ok()) {
    return after.status();
  }
  // The first free one: the fewer batches are in use, the better they stay in the caches.
  const auto free = std::find_if(after->begin(), after->end(), [](const Entry& entry) {
    return !entry.held && entry.kept_for == 0;
  });
  if (free == after->end()) {
    const auto held =
        std::count_if(after->begin(), after->end(), [](const Entry& entry) { return entry.held; });
    return absl::FailedPreconditionError(absl::StrCat(
        "the learner holds ", held, " of the ", after->size(), " batches of shared memory, and ",
        static_cast<int64_t>(after->size()) - held,
        " more are kept for requests that may be asked again, so there is none for another answer; "
        "release some (released_batches), or attach with a larger held_batches_max"));
  }
  *free = {true, keeps ? number : 0};
  const auto batch = static_cast<int32_t>(free - after->begin());
  entries_ = *std::move(after);
  return batch;
}

void SlotTable::HoldAgain(int64_t number) {
  for (Entry& entry : entries_) {
    entry.held = entry.held || entry.kept_for == number;
  }
}

void SlotTable::ForgetUpTo(int64_t number) {
  for (Entry& entry : entries_) {
    entry.kept_for = entry.kept_for <= number ? 0 : entry.kept_for;
  }
}

}  // namespace procgen
