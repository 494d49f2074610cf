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
#include "procgen_client/call_options.h"
#include "procgen_client/cancellation.h"
#include "procgen_client/observation_decoder.h"
#include "procgen_client/response_validator.h"
#include "procgen_client/shared_mapping.h"
#include "procgen_client/stream_connection.h"

namespace procgen_client {

struct StreamOptions {
  int32_t requests_in_flight_max = 2;  // that may be sent ahead of the answers; 1 ... the server's
  // Largest response, in bytes; 0: 4 MiB. A larger answer comes in several responses, which Receive
  // joins. More than 4 MiB: the client must have been connected with as much. A pool whose
  // observations are larger than that answers RESOURCE_EXHAUSTED and how much it needs.
  int64_t response_bytes_max = 0;
  // How long a stream whose connection broke tries to go on, each time. The server keeps its
  // answers meanwhile, so that no step is lost or taken twice. 0: a broken connection ends the
  // stream, and the server keeps nothing.
  absl::Duration reconnect_timeout = absl::Minutes(1);
  // In how many chunks Step and SendStep have the pool stepped, in [0, 64]: while one is on its
  // way, the next is stepped. The step is one request all the same, taken whole or not at all. 0:
  // as many as pay for observations of this size.
  int32_t chunk_count = 0;
  // Another stream that has the pool ends.
  bool take_over = false;
  // Of a pool with TRANSPORT_SHARED_MEMORY: how many Batches may be held besides those of
  // unanswered requests; 0: 2. Each takes memory for two observations of each environment.
  int32_t held_batches_max = 0;
  // Of such a pool: messages go past gRPC by two pipes, where the server can give them, which costs
  // less than half. False: by gRPC's stream, where its interceptors see them.
  bool pipe_transport = true;
  // Of such a pool: what the learner holds of its memory from streams before
  // (StepStream::held_batches). Null: nothing.
  std::shared_ptr<HeldBatches> held_batches = nullptr;
};

// One learner's hold of one pool. Made by Client::Attach, which it must not outlive.
//
// Either call Step, which sends and receives; or Send up to requests_in_flight_max() requests ahead
// and Receive their answers, in order.
//
// Where the connection breaks, the stream attaches again by itself and sends again what is
// unanswered: its user sees nothing but a pause, unless that takes longer than reconnect_timeout.
//
// Observations that the pool sends encoded (PoolSpec.encoding) are decoded: batches bear the same
// bytes whatever the encoding is. Damaged ones end the stream with DATA_LOSS.
//
// Every response is validated before it is read. One that does not fit its request, whatever server
// sent it, ends the stream with DATA_LOSS (an answer to attach with INTERNAL).
//
// Waits end with CANCELLED when ConnectOptions::is_cancelled says so, and the stream with them.
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

  // What is held of the memory that the pool shares; a later stream of the same learner takes it
  // over (StreamOptions::held_batches).
  const std::shared_ptr<HeldBatches>& held_batches() const { return held_; }
  // How many batches that memory has; 0: the pool shares none.
  int32_t shared_batch_count() const { return mapping_ == nullptr ? 0 : mapping_->batch_count(); }

  // In how many chunks a step of the whole pool is carried out.
  int32_t chunk_count() const { return chunk_count_; }

  // Steps the whole pool and waits for the answer. `actions`: [env_count()], each in [-1, 15).
  // REQUIRES: nothing is unanswered.
  absl::Status Step(absl::Span<const int32_t> actions, Batch* batch);
  // The same for any request; its sequence number is set here.
  absl::Status Call(procgen::v1::StepPoolRequest request, Batch* batch);
  // Tells how the whole pool stands; how a learner gets its first observations.
  absl::Status Observe(Batch* batch);

  // Replaces what chooses the pool's levels; takes effect at each environment's next choice.
  // REQUIRES: nothing is unanswered.
  absl::Status SetLevelSampler(procgen::v1::LevelSampler level_sampler);

  // Sends a request and returns its sequence number. Blocks only while the connection is full, or
  // Receive makes it anew; that it is broken, only Receive finds.
  // Errors: FAILED_PRECONDITION requests_in_flight_max() are unanswered, or so many Batches of
  // shared memory are held that there is none for the answer (nothing was sent).
  absl::StatusOr<int64_t> Send(procgen::v1::StepPoolRequest request);
  // Sends the request of Step, whose answer Receive waits for: what the learner does meanwhile
  // costs no time. Returns and errors as Send.
  absl::StatusOr<int64_t> SendStep(absl::Span<const int32_t> actions);
  // Waits for the answer to the oldest unanswered request; that to a level_sampler is a batch of no
  // environments. Errors: FAILED_PRECONDITION there is
  // none; those of the server.
  absl::Status Receive(Batch* batch);

  // Breaks the connection, from any thread: who sends or receives finds it broken. A stream that
  // does not resume (StreamOptions::reconnect_timeout 0) is over then.
  void Cancel();

  // Ends the stream at once, from any thread: waits end with CANCELLED, within 50 ms.
  void Abort();

  // Ends the stream; the pool stays. Answers that were not received are dropped. Returns what the
  // server says of the stream, or DEADLINE_EXCEEDED if it does not end it within 10 s. Further
  // calls return FAILED_PRECONDITION.
  absl::Status Close();

 private:
  friend class Client;
  // `terms`: their timeout is that of the first attach.
  StepStream(procgen::v1::StepService::Stub* stub, const CallOptions& terms,
             const std::string& pool, const StreamOptions& options);
  bool resumes() const { return reconnect_timeout_ > absl::ZeroDuration(); }
  absl::Status Attach();
  procgen::v1::StepPoolRequest StepRequest(absl::Span<const int32_t> actions);
  // Attaches with a new connection, within `timeout`. `is_broken`: whether an error may be another
  // one the next time.
  absl::Status Open(absl::Duration timeout, procgen::v1::Attached* attached, bool* is_broken)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Validates `attached`, which must be of the same pool as before, and maps the memory that the
  // pool shares, if it does. Errors: those of ValidateAttached and SharedMapping::Open; ABORTED it
  // is another pool of the same name.
  absl::Status Accept(const procgen::v1::Attached& attached)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Maps the memory that the pool shares, or more of it than before. Errors: as Accept.
  absl::Status MapShared(const procgen::v1::Attached& attached)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Whether there is a batch of shared memory for one more answer.
  absl::Status CheckHeld(int64_t unanswered) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Goes on with a new connection after one broke, or ends the stream.
  absl::Status Reconnect();
  // Attaches again and sends again what is unanswered.
  absl::Status Resume(absl::Duration timeout, bool* is_broken)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  // Reads the answer to one request; false: the stream has ended. Errors: DATA_LOSS a response is
  // not valid.
  absl::StatusOr<bool> ReadAnswer(Batch* batch);
  // Decodes the observations of a whole answer, or finds its values in shared memory.
  absl::Status Understand(Batch* batch);
  // Why a connection ended, and whether because it broke.
  static absl::Status EndOf(const std::shared_ptr<StreamConnection>& connection, bool* is_broken);
  // OK while the stream goes on; afterwards what every call returns.
  absl::Status Over();
  // What the server says of the stream; it is over.
  absl::Status Finish();
  absl::Status FinishWith(absl::Status status);
  // Ends a stream whose answers make no sense.
  absl::Status GiveUp(absl::Status status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(send_mutex_);
  std::shared_ptr<StreamConnection> connection();

  procgen::v1::StepService::Stub* const stub_;
  const std::string token_;  // empty: none
  const absl::Duration attach_timeout_;
  const std::shared_ptr<Cancellation> cancellation_;
  const absl::Duration reconnect_timeout_;
  const bool wants_pipe_transport_;
  int32_t chunk_count_;  // 0: until it is attached
  procgen::v1::StepPoolRequest attach_;
  procgen::v1::Attached attached_;  // at first
  ResponseValidator validator_;
  procgen::v1::StepPoolResponse part_;  // of answers in several responses, after the first
  // Null where observations are not encoded. It outlives connections: answers that are given again
  // follow those that were decoded before the connection broke.
  std::unique_ptr<ObservationDecoder> decoder_;
  std::atomic<int64_t> next_sequence_number_ = 1;
  std::atomic<int64_t> answered_sequence_number_ = 0;
  // Set by attaching, with send_mutex_ held, and read by who receives or with send_mutex_ held.
  // Null: values are received.
  std::shared_ptr<const SharedMapping> mapping_;
  const std::shared_ptr<HeldBatches> held_;

  // Lock order: send_mutex_, mutex_.
  absl::Mutex send_mutex_;  // of who writes, or makes the connection anew
  absl::Mutex mutex_;
  std::shared_ptr<StreamConnection> connection_ ABSL_GUARDED_BY(mutex_);
  std::deque<procgen::v1::StepPoolRequest> unanswered_ ABSL_GUARDED_BY(mutex_);
  procgen::v1::StepPoolRequest answered_ ABSL_GUARDED_BY(mutex_);  // whose memory the next one has
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_STEP_STREAM_H_
