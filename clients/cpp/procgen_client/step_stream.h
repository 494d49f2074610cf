#ifndef PROCGEN_CLIENT_STEP_STREAM_H_
#define PROCGEN_CLIENT_STEP_STREAM_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "procgen/v1/step.grpc.pb.h"
#include "procgen_client/batch.h"
#include "procgen_client/cancellation.h"
#include "procgen_client/internal/call_options.h"
#include "procgen_client/internal/response_validator.h"
#include "procgen_client/internal/shared_mapping.h"
#include "procgen_client/internal/stream_connection.h"
#include "procgen_client/observation_decoder.h"

namespace procgen_client {

struct StreamOptions {
  // Maximum number of unanswered requests, from 1 to Limits.requests_in_flight_max.
  int32_t requests_in_flight_max = 2;
  // Largest response, in bytes; 0: 4 MiB. Larger values require the same in
  // ConnectOptions::response_bytes_max. A larger answer arrives in several responses, which Receive
  // joins. If a single environment does not fit, requests are RESOURCE_EXHAUSTED, and the message
  // contains the size needed.
  int64_t response_bytes_max = 0;
  // Time that the stream tries to resume after a broken connection. The server keeps its answers
  // meanwhile, so no step is lost or executed twice. 0: a broken connection ends the stream, and
  // the server keeps nothing.
  absl::Duration reconnect_timeout = absl::Minutes(1);
  // Number of responses to a step of the whole pool (Step.chunk_count), in [0, 64]. 0: one for each
  // 2 MiB of observations, from 1 to 4.
  int32_t chunk_count = 0;
  // True: ends another stream that is attached to the pool.
  bool take_over = false;
  // With TRANSPORT_SHARED_MEMORY: number of Batches that may be held in addition to those of
  // unanswered requests; 0: 2. Each takes memory for two observations of each environment.
  int32_t held_batches_max = 0;
  // With TRANSPORT_SHARED_MEMORY: use pipes in place of gRPC for messages if the server offers
  // them, at less than half the cost. False: use gRPC's stream, which interceptors can see.
  bool pipe_transport = true;
  // Of such a pool: what the learner holds of its memory from streams before
  // (StepStream::held_batches). Null: nothing.
  std::shared_ptr<HeldBatches> held_batches = nullptr;
};

// A stream that is attached to one pool. Created by Client::Attach; the client must outlive it.
//
// Either call Step, which sends a request and receives its answer, or Send up to
// requests_in_flight_max() requests ahead and Receive their answers in order.
//
// After a broken connection the stream attaches again and resends all unanswered requests. Calls
// block meanwhile, and fail after reconnect_timeout.
//
// Encoded observations (PoolSpec.encoding) are decoded: a Batch contains the same bytes with any
// encoding.
//
// Every response is validated before it is read. One that does not match its request, or contains
// malformed observations, ends the stream with DATA_LOSS (the response to attach: with INTERNAL).
//
// When ConnectOptions::is_cancelled returns true, waits end with CANCELLED, and so does the stream.
//
// An error of the server ends the stream: every further call returns that error. The pool stays and
// can be attached again.
// Threads: one may send while another receives; otherwise one at a time.
class StepStream {
 public:
  // Calls Close and ignores its result.
  ~StepStream();
  StepStream(const StepStream&) = delete;
  StepStream& operator=(const StepStream&) = delete;

  // The pool as it was when the stream was attached.
  const procgen::v1::Pool& pool() const { return attached_.pool(); }
  int32_t env_count() const { return pool().spec().env_count(); }
  int32_t requests_in_flight_max() const { return attached_.requests_in_flight_max(); }
  int64_t response_bytes_max() const { return attached_.response_bytes_max(); }

  // The batches of shared memory that are held. A later stream of the same learner takes them over
  // (StreamOptions::held_batches).
  const std::shared_ptr<HeldBatches>& held_batches() const { return held_; }
  // Number of batches in shared memory; 0 without shared memory.
  int32_t shared_batch_count() const { return mapping_ == nullptr ? 0 : mapping_->batch_count(); }

  // Number of responses to a step of the whole pool.
  int32_t chunk_count() const { return chunk_count_; }

  // Steps the whole pool and waits for the answer. `actions`: [env_count()], each in [-1, 15).
  // `annotations`: values for viewers of the pool (procgen.v1.Step.annotations).
  // REQUIRES: nothing is unanswered.
  absl::Status Step(absl::Span<const int32_t> actions, Batch* batch,
                    std::vector<procgen::v1::Annotation> annotations = {});
  // The same for any request; its sequence number is set here.
  absl::Status Call(procgen::v1::StepPoolRequest request, Batch* batch);
  // Returns the current values of the whole pool, e.g. the first observations.
  absl::Status Observe(Batch* batch);

  // Replaces the pool's level sampler, from each environment's next choice of a level.
  // REQUIRES: nothing is unanswered.
  absl::Status SetLevelSampler(procgen::v1::LevelSampler level_sampler);

  // Sends a request and returns its sequence number. Blocks only while the connection is full or
  // Receive reconnects. Only Receive detects a broken connection.
  // Errors: FAILED_PRECONDITION requests_in_flight_max() requests are unanswered, or all batches of
  // shared memory are held (nothing was sent).
  absl::StatusOr<int64_t> Send(procgen::v1::StepPoolRequest request);
  // Sends the request of Step without waiting for its answer, so that the learner can work until it
  // calls Receive. Returns and errors as Send.
  absl::StatusOr<int64_t> SendStep(absl::Span<const int32_t> actions,
                                   std::vector<procgen::v1::Annotation> annotations = {});
  // Blocks until the answer to the oldest unanswered request has arrived. The answer to a
  // level_sampler is a batch of 0 environments. Errors: FAILED_PRECONDITION no request is
  // unanswered; those of the server.
  absl::Status Receive(Batch* batch);

  // Breaks the connection, from any thread. Calls that send or receive then reconnect, or, with
  // StreamOptions::reconnect_timeout 0, fail and end the stream.
  void Cancel();

  // Ends the stream at once, from any thread: waits end with CANCELLED, within 50 ms.
  void Abort();

  // Ends the stream; the pool stays. Answers that were not received are dropped. Returns what the
  // server says of the stream, or DEADLINE_EXCEEDED if it does not end it within 10 s. Further
  // calls return FAILED_PRECONDITION.
  absl::Status Close();

 private:
  friend class Client;
  // `call_options.timeout`: deadline of the first attach.
  StepStream(procgen::v1::StepService::Stub* stub, const CallOptions& call_options,
             const std::string& pool, const StreamOptions& options);
  bool resumes() const { return reconnect_timeout_ > absl::ZeroDuration(); }
  absl::Status Attach();
  procgen::v1::StepPoolRequest StepRequest(absl::Span<const int32_t> actions,
                                           std::vector<procgen::v1::Annotation> annotations);
  // Attaches with a new connection, within `timeout`. Sets `is_broken` to whether a retry after an
  // error may succeed.
  absl::Status Open(absl::Duration timeout, procgen::v1::Attached* attached, bool* is_broken)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Validates `attached`, which must be from the same pool as before, and maps its shared memory.
  // Errors: those of ValidateAttached and SharedMapping::Open; ABORTED it is another pool of the
  // same name.
  absl::Status Accept(const procgen::v1::Attached& attached)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Maps the pool's shared memory, again if it has grown. Errors: as Accept.
  absl::Status MapShared(const procgen::v1::Attached& attached)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // OK if a batch of shared memory is free for one more answer.
  absl::Status CheckHeld(int64_t unanswered) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Resumes with a new connection after one broke, or ends the stream.
  absl::Status Reconnect();
  // Attaches again and resends all unanswered requests.
  absl::Status Resume(absl::Duration timeout, bool* is_broken)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Reads the answer to one request; false: the stream has ended. Errors: DATA_LOSS an invalid
  // response.
  absl::StatusOr<bool> ReadAnswer(Batch* batch);
  // Decodes the observations of a whole answer, or sets its rows in shared memory.
  absl::Status Understand(Batch* batch);
  // Returns why a connection ended, and whether it broke.
  static absl::Status EndOf(const std::shared_ptr<StreamConnection>& connection, bool* is_broken);
  // OK while the stream is open; afterwards the error that every call returns.
  absl::Status Over();
  // Ends the stream and returns its status.
  absl::Status Finish();
  absl::Status FinishWith(absl::Status status);
  // Cancels and ends a stream with invalid responses.
  absl::Status GiveUp(absl::Status status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  std::shared_ptr<StreamConnection> connection();

  procgen::v1::StepService::Stub* const stub_;
  const std::string token_;  // empty: no token
  const absl::Duration attach_timeout_;
  const std::shared_ptr<Cancellation> cancellation_;
  const absl::Duration reconnect_timeout_;
  const bool wants_pipe_transport_;
  int32_t chunk_count_;  // 0 until attached, if chosen by default
  procgen::v1::StepPoolRequest attach_;
  procgen::v1::Attached attached_;  // of the first connection
  ResponseValidator validator_;
  procgen::v1::StepPoolResponse part_;  // responses of an answer after the first
  // Null without an encoding. Kept over connections: answers that are sent again are deltas to
  // those decoded before the connection broke.
  std::unique_ptr<ObservationDecoder> decoder_;
  std::atomic<int64_t> next_sequence_number_ = 1;
  std::atomic<int64_t> answered_sequence_number_ = 0;
  // Set while attaching, with send_mutex_ held; read by the receiving thread or with send_mutex_
  // held. Null without shared memory.
  std::shared_ptr<const SharedMapping> mapping_;
  const std::shared_ptr<HeldBatches> held_;

  // Lock order: send_mutex_, mutex_.
  absl::Mutex send_mutex_;  // held while writing or reconnecting
  absl::Mutex mutex_;
  std::shared_ptr<StreamConnection> connection_ ABSL_GUARDED_BY(mutex_);
  std::deque<procgen::v1::StepPoolRequest> unanswered_ ABSL_GUARDED_BY(mutex_);
  procgen::v1::StepPoolRequest answered_ ABSL_GUARDED_BY(mutex_);  // its memory is reused
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_STEP_STREAM_H_
