#ifndef SERVER_SESSION_POOL_RESUME_BUFFER_H_
#define SERVER_SESSION_POOL_RESUME_BUFFER_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/session/backend/request.h"
#include "server/session/pool/attach_options.h"
#include "server/session/pool/kept_answers.h"
#include "server/session/quota/byte_budget.h"
#include "server/shared_memory/slot_table.h"

namespace procgen {

// What a pool keeps so that streams can be resumed: the answers to the last requests, within a byte
// budget that all pools share; and, where answers are in shared memory, which batches they are in.
// Threads: any method from any thread.
class ResumeBuffer {
 public:
  // An answer, kept, has at most `answer_bytes_max`. `budget` must outlive this. `shares_memory`:
  // answers are in batches of shared memory.
  ResumeBuffer(std::string pool_name, int64_t answer_bytes_max, ByteBudget* budget,
               bool shares_memory);
  // Gives back what it has reserved.
  ~ResumeBuffer();
  ResumeBuffer(const ResumeBuffer&) = delete;
  ResumeBuffer& operator=(const ResumeBuffer&) = delete;

  // Checks what a stream asks for that wants to attach, and reserves bytes for its answers. Errors:
  // INVALID_ARGUMENT batches that cannot be held; RESOURCE_EXHAUSTED the budget is used up.
  absl::Status Reserve(const AttachOptions& options);
  // A stream attaches. What was kept for others is forgotten, unless it is resumable.
  void BeginStream(const AttachOptions& options, int64_t next_sequence_number);
  // A stream waits for the one that is attached.
  void SetSuccessor(const AttachOptions& options);
  // There are `batch_count` batches of shared memory now, at least as many as before.
  void GrowBatches(int32_t batch_count);

  // Takes a new request: forgets the answers that it acknowledges or that have left the window, and
  // fills in the batch of shared memory that it is answered in. Returns whether its answer is to be
  // kept. Errors, which change nothing: INVALID_ARGUMENT released batches; FAILED_PRECONDITION no
  // batch is free.
  absl::StatusOr<bool> Take(Request* request);
  // The answer to a request that was executed before. Errors: FAILED_PRECONDITION it is not kept.
  absl::StatusOr<Answer> Recall(const Request& request, int64_t next_sequence_number);
  void Keep(int64_t sequence_number, Answer answer);
  // The least number of which the answer is kept; `none` where none is.
  int64_t OldestOr(int64_t none) const;

 private:
  // Gives back what is reserved beyond the answers that are kept and those that the present stream
  // and its successor may have kept.
  void TrimReservation() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string pool_name_;
  const int64_t answer_bytes_max_;
  ByteBudget* const budget_;
  const bool shares_memory_;

  mutable absl::Mutex mutex_;
  AttachOptions stream_ ABSL_GUARDED_BY(mutex_);                // of the last one attached
  int32_t successor_answer_count_ ABSL_GUARDED_BY(mutex_) = 0;  // that the one that waits may have
  KeptAnswers kept_ ABSL_GUARDED_BY(mutex_);
  int64_t reserved_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // of the budget, for kept_
  SlotTable slots_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_RESUME_BUFFER_H_
