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
#include "server/session/pool/answer_cache.h"
#include "server/session/pool/attach_options.h"
#include "server/session/quota/byte_budget.h"
#include "server/shared_memory/slot_table.h"

namespace procgen {

// What a pool keeps so that streams can resume: the answers to its last requests, within a byte
// budget that all pools share. With shared memory: which batches contain them.
// Threads: any method from any thread.
class ResumeBuffer {
 public:
  // `answer_bytes_max`: maximum bytes of one kept answer. `budget` must outlive this.
  // `shares_memory`: answers are in batches of shared memory.
  ResumeBuffer(std::string pool_name, int64_t answer_bytes_max, ByteBudget* budget,
               bool shares_memory);
  // Releases its reservation.
  ~ResumeBuffer();
  ResumeBuffer(const ResumeBuffer&) = delete;
  ResumeBuffer& operator=(const ResumeBuffer&) = delete;

  // Checks the options of a stream that is about to attach, and reserves bytes for its answers.
  // Errors: INVALID_ARGUMENT batches that cannot be held; RESOURCE_EXHAUSTED the budget is
  // exceeded.
  absl::Status Reserve(const AttachOptions& options);
  // A stream attaches. Answers kept for earlier streams are dropped unless it is resumable.
  void BeginStream(const AttachOptions& options, int64_t next_sequence_number);
  // A stream waits for the attached one to detach.
  void SetSuccessor(const AttachOptions& options);
  // Sets the number of shared-memory batches. REQUIRES: not fewer than before.
  void GrowBatches(int32_t batch_count);

  // Accepts a new request: drops the answers that it acknowledges or that have left the window, and
  // sets its shared-memory batch. Returns whether its answer is to be kept. Errors, which change
  // nothing: INVALID_ARGUMENT released batches; FAILED_PRECONDITION no batch is free.
  absl::StatusOr<bool> Take(Request* request);
  // Returns the answer to a request that was executed before. Errors: FAILED_PRECONDITION it is not
  // kept.
  absl::StatusOr<Answer> Recall(const Request& request, int64_t next_sequence_number);
  void Keep(int64_t sequence_number, Answer answer);
  // Returns the lowest number with a kept answer; `none` if there is none.
  int64_t OldestOr(int64_t none) const;

 private:
  // Releases what is reserved beyond the kept answers and those of the current stream and its
  // successor.
  void TrimReservation() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string pool_name_;
  const int64_t answer_bytes_max_;
  ByteBudget* const budget_;
  const bool shares_memory_;

  mutable absl::Mutex mutex_;
  AttachOptions stream_ ABSL_GUARDED_BY(mutex_);                // of the last stream attached
  int32_t successor_answer_count_ ABSL_GUARDED_BY(mutex_) = 0;  // answers of the waiting stream
  AnswerCache kept_ ABSL_GUARDED_BY(mutex_);
  int64_t reserved_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // of the budget, for kept_
  SlotTable slots_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_RESUME_BUFFER_H_
