#ifndef SERVER_RPC_RUNNING_REQUEST_H_
#define SERVER_RPC_RUNNING_REQUEST_H_

#include <cstdint>
#include <memory>

#include "absl/time/time.h"
#include "server/encoding/observation_encoder.h"
#include "server/rpc/convert_step.h"
#include "server/rpc/frame_ring.h"
#include "server/rpc/response.h"
#include "server/rpc/response_queue.h"
#include "server/session/alarm.h"
#include "server/session/pool_session.h"

namespace procgen {

// A request that a stream carries out, part by part: each part is stepped straight into a response,
// and its frames are drawn into the memory that they are sent from. Where answers are kept, they
// are gathered here. Observations are encoded, if the pool has them so: each stream begins anew, so
// that who attaches needs nothing that others received.
// Threads: compatible; whoever has the stream's turn uses it.
class RunningRequest {
 public:
  // The next one to carry out. REQUIRES: it was accepted.
  void Begin(StreamRequest* request);

  // Steps the next part into `response` (null: for nobody), then calls `done`. `near_end`: as that
  // of Pool::StepAsync.
  void RunPart(PoolSession* pool, Response* response, PoolSession::Done done,
               PoolSession::NearEnd near_end = nullptr);
  // Ends the part, which was stepped or, if not `ok`, was not; returns its response to be sent or,
  // if not `ok`, to be given back. `keeps`: the response also becomes a part of the answer.
  Outgoing EndPart(const PoolSession& pool, bool ok, bool keeps);
  // Whether there is no further part.
  bool IsOver() const { return rest_ == 0; }

  // From its arrival until it began, and since then.
  absl::Duration queued() const { return queued_; }
  absl::Duration ran() const { return SteadyNow() - begin_time_; }

  int64_t sequence_number() const { return sequence_number_; }
  // What is to be kept; empty: nothing.
  Answer TakeAnswer();
  // Lets go of what is kept from request to request; no other comes.
  void EndStream() { encoder_ = nullptr; }

 private:
  // Puts the encoded observations in place of those that were drawn.
  void Encode(const PoolSession& pool, Response* response);
  // The range after part_, as large as all that are left.
  void SelectNextPart();

  StreamRequest* request_ = nullptr;  // until its last response is sent
  int64_t sequence_number_ = 0;
  absl::Time begin_time_;
  absl::Duration queued_;
  Part part_;               // the next, or that which runs
  int32_t rest_ = 0;        // environments from part_ on
  int32_t parts_left_ = 0;  // after part_
  Response* response_ = nullptr;
  FrameRing frames_;
  Batch batch_;    // where the values of the part that runs are written
  Answer answer_;  // as far as it goes
  // Made for the first observations; null before, and where they are not encoded.
  std::unique_ptr<ObservationEncoder> encoder_;
};

}  // namespace procgen

#endif  // SERVER_RPC_RUNNING_REQUEST_H_
