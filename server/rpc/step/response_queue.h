#ifndef SERVER_RPC_STEP_RESPONSE_QUEUE_H_
#define SERVER_RPC_STEP_RESPONSE_QUEUE_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "grpcpp/support/byte_buffer.h"
#include "server/rpc/step/response.h"
#include "server/session/pool/answer_cache.h"
#include "server/wire/convert_step.h"

namespace procgen {

// Whether an answer that was kept, to request `sequence_number`, can be sent on a stream that takes
// responses of this size. Errors: RESOURCE_EXHAUSTED.
absl::Status CheckKeptAnswer(int64_t sequence_number, const Answer& answer,
                             int64_t response_bytes_max);

// A response on its way.
struct Outgoing {
  Response* response = nullptr;       // of the queue's; null: only its bytes are there
  grpc::ByteBuffer bytes;             // not valid: to be serialised from the response
  StreamRequest* answered = nullptr;  // the request of which this is the last response
};

// The responses of a stream: those that are stepped into, and those to be written, in order. The
// memory of their messages is kept, so there are two: one is stepped into while the other is on its
// way.
// Threads: compatible; what BeginWrite returned may be used by who called it until EndWrite.
class ResponseQueue {
 public:
  ResponseQueue();

  bool has_free() const { return !free_.empty(); }
  // A free response; if there is none, another one is made.
  Response* Take();
  // Lets go of its observations.
  void GiveBack(Response* response);

  void Push(Outgoing response) { queue_.push_back(std::move(response)); }
  // Pushes an answer that was kept, to `request`.
  void PushAnswer(const Answer& answer, StreamRequest* request);
  bool empty() const { return queue_.empty(); }
  bool CanWrite() const { return !queue_.empty() && !writing_; }
  void BeginWrite() { writing_ = true; }
  Outgoing* writing() { return &queue_.front(); }
  // Returns the request that is answered by what was written; null: there is more to it.
  StreamRequest* EndWrite();
  // Drops all but what is being written.
  void DropUnwritten();

 private:
  std::vector<std::unique_ptr<Response>> responses_;
  std::vector<Response*> free_;
  std::deque<Outgoing> queue_;
  bool writing_ = false;  // the first of queue_
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_RESPONSE_QUEUE_H_
