#ifndef SERVER_SHARED_MEMORY_SLOT_TABLE_H_
#define SERVER_SHARED_MEMORY_SLOT_TABLE_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// Who needs which batch of a shared mapping: the learner holds it, from when it is written until
// it is released; or it is kept, because the request that it answers may be asked again. Others
// may be written.
// Threads: compatible.
class SlotTable {
 public:
  int32_t batch_count() const { return static_cast<int32_t>(entries_.size()); }
  // How many the learner holds.
  int32_t HeldCount() const;

  // What concerns batches in a request.
  struct Change {
    absl::Span<const int32_t> released;  // by the learner
    int64_t forgotten = 0;  // answers to requests up to this number are not kept any more
  };

  // Checks that the learner can hold `held`. Errors: INVALID_ARGUMENT no such batch, or twice.
  absl::Status CheckHeld(absl::Span<const int32_t> held) const;
  // A stream begins whose learner holds `held` and nothing else. REQUIRES: CheckHeld.
  void BeginStream(absl::Span<const int32_t> held);
  // Has `batch_count` batches from now on, if it had fewer.
  void Grow(int32_t batch_count);

  // Releases and forgets. On error nothing has changed. Errors: INVALID_ARGUMENT a released batch
  // is not held.
  absl::Status Apply(const Change& change);
  // The same, and then has a batch for the answer to request `number`, which the learner holds from
  // now on and which, if it `keeps`, is kept. Errors: also FAILED_PRECONDITION none is free.
  absl::StatusOr<int32_t> Take(const Change& change, int64_t number, bool keeps);
  // The learner holds again what was kept for `number`.
  void HoldAgain(int64_t number);
  void ForgetUpTo(int64_t number);

 private:
  struct Entry {
    bool held = false;
    int64_t kept_for = 0;  // the request; 0: none
  };
  using Entries = std::vector<Entry>;

  absl::StatusOr<Entries> After(const Change& change) const;

  Entries entries_;  // by number
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_SLOT_TABLE_H_
