#ifndef PROCGEN_CLIENT_STEP_STREAM_H_
#define PROCGEN_CLIENT_STEP_STREAM_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/types/span.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "procgen/v1/step.grpc.pb.h"
#include "procgen_client/batch.h"

namespace procgen_client {

struct StreamOptions {
  int32_t requests_in_flight_max = 2;  // that may be sent ahead of the answers; 1 ... the server's
  // Largest response, in bytes; 0: 4 MiB. A larger answer comes in several responses, which Receive
  // joins. More than 4 MiB: the client must have been connected with as much. A pool whose
  // observations are larger than that answers RESOURCE_EXHAUSTED and how much it needs.
  int64_t response_bytes_max = 0;
};

// One learner's hold of one pool. Made by Client::Attach, which it must not outlive.
//
// Either call Step, which sends and receives; or Send up to requests_in_flight_max() requests ahead
// and Receive their answers, in order.
//
// After an error of the server the stream is over: every further call returns that same error. The
// pool stays, and can be attached again.
// Threads: one may send while another receives; otherwise one at a time.
class StepStream {
 public:
  // Closes, without looking at what is still unanswered.
  ~StepStream();
  StepStream(const StepStream&) = delete;
  StepStream& operator=(const StepStream&) = delete;

  // The pool as it was when the stream was attached.
  const procgen::v1::Pool& pool() const { return attached_.pool(); }
  int32_t env_count() const { return pool().spec().env_count(); }
  int32_t requests_in_flight_max() const { return attached_.requests_in_flight_max(); }
  int64_t response_bytes_max() const { return attached_.response_bytes_max(); }

  // Steps the whole pool and waits for the answer. `actions`: [env_count()], each in [-1, 15).
  // REQUIRES: nothing is unanswered.
  absl::Status Step(absl::Span<const int32_t> actions, Batch* batch);
  // The same for any request; its sequence number is set here.
  absl::Status Call(procgen::v1::StepPoolRequest request, Batch* batch);
  // Tells how the whole pool stands; how a learner gets its first observations.
  absl::Status Observe(Batch* batch);

  // Sends a request and returns its sequence number. Blocks only while the connection is full.
  // Errors: FAILED_PRECONDITION requests_in_flight_max() are unanswered (nothing was sent).
  absl::StatusOr<int64_t> Send(procgen::v1::StepPoolRequest request);
  // Waits for the answer to the oldest unanswered request. Errors: FAILED_PRECONDITION there is
  // none; those of the server.
  absl::Status Receive(Batch* batch);

  // Ends the stream; the pool stays. Answers that were not received are dropped. Returns what the
  // server says of the stream. Further calls return FAILED_PRECONDITION.
  absl::Status Close();

 private:
  friend class Client;
  using ReaderWriter =
      grpc::ClientReaderWriter<procgen::v1::StepPoolRequest, procgen::v1::StepPoolResponse>;

  StepStream() = default;
  absl::Status Attach(procgen::v1::StepService::Stub* stub, const std::string& token,
                      const std::string& pool, const StreamOptions& options);
  // OK while the stream goes on; afterwards what every call returns.
  absl::Status Over();
  // What the server says of the stream; it is over.
  absl::Status Finish();
  absl::Status Read(procgen::v1::StepPoolResponse* response);

  grpc::ClientContext context_;
  std::unique_ptr<ReaderWriter> stream_;
  procgen::v1::Attached attached_;
  procgen::v1::StepPoolResponse part_;  // of answers in several responses, after the first
  std::atomic<int64_t> next_sequence_number_ = 1;
  std::atomic<int64_t> answered_sequence_number_ = 0;
  absl::Mutex mutex_;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_STEP_STREAM_H_
