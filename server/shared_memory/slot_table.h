#ifndef SERVER_SHARED_MEMORY_SLOT_TABLE_H_
#define SERVER_SHARED_MEMORY_SLOT_TABLE_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// The state of each batch of a shared mapping: held by the learner, from its writing until its
// release; or kept, because its request may be repeated; or free.
// Threads: compatible.
class SlotTable {
 public:
  int32_t batch_count() const { return static_cast<int32_t>(entries_.size()); }
  // Number of batches that the learner holds.
  int32_t HeldCount() const;

  // The parts of a request that concern batches.
  struct Change {
    absl::Span<const int32_t> released;  // by the learner
    int64_t forgotten = 0;               // answers up to this request number are no longer kept
  };

  // Checks that the learner can hold `held`. Errors: INVALID_ARGUMENT no such batch, or a
  // duplicate.
  absl::Status CheckHeld(absl::Span<const int32_t> held) const;
  // Begins a stream whose learner holds exactly `held`. REQUIRES: CheckHeld.
  void BeginStream(absl::Span<const int32_t> held);
  // Grows to `batch_count` batches; never shrinks.
  void Grow(int32_t batch_count);

  // Releases batches and drops kept ones. On error nothing has changed. Errors: INVALID_ARGUMENT a
  // released batch is not held.
  absl::Status Apply(const Change& change);
  // As above, then takes a batch for the answer to request `number`. The learner holds it from now
  // on; if `keeps`, it is also kept. Errors: also FAILED_PRECONDITION none is free.
  absl::StatusOr<int32_t> Take(const Change& change, int64_t number, bool keeps);
  // The learner holds the batch kept for `number` again.
  void HoldAgain(int64_t number);
  void ForgetUpTo(int64_t number);

 private:
  struct Entry {
    bool held = false;
    int64_t kept_for = 0;  // the request number; 0: none
  };
  using Entries = std::vector<Entry>;

  absl::StatusOr<Entries> After(const Change& change) const;

  Entries entries_;  // by batch number
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_SLOT_TABLE_H_
