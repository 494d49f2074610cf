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

// Checks that the kept answer to request `sequence_number` can be sent on a stream with this limit.
// Errors: RESOURCE_EXHAUSTED a response of it is larger.
absl::Status CheckKeptAnswer(int64_t sequence_number, const Answer& answer,
                             int64_t response_bytes_max);

// A response in the send queue.
struct Outgoing {
  Response* response = nullptr;       // owned by the queue; null: there are only `bytes`
  grpc::ByteBuffer bytes;             // not valid: `response` is not serialised yet
  StreamRequest* answered = nullptr;  // the request whose last response this is; null: not the last
};

// The responses of a stream: those being filled, and the queue of those to send. Two messages are
// reused in turn: one is filled while the other is sent.
// Threads: compatible; the result of writing() may be used without a lock from BeginWrite to
// EndWrite.
class ResponseQueue {
 public:
  ResponseQueue();

  bool has_free() const { return !free_.empty(); }
  // Returns a free response, or a new one if none is free.
  Response* Take();
  // Frees the response and releases its observations.
  void Release(Response* response);

  void Push(Outgoing response) { queue_.push_back(std::move(response)); }
  // Pushes the responses of a kept answer to `request`.
  void PushAnswer(const Answer& answer, StreamRequest* request);
  bool empty() const { return queue_.empty(); }
  bool CanWrite() const { return !queue_.empty() && !writing_; }
  void BeginWrite() { writing_ = true; }
  Outgoing* writing() { return &queue_.front(); }
  // Removes the written response. Returns the request that it completes; null: more responses
  // follow.
  StreamRequest* EndWrite();
  // Drops all responses but the one being written.
  void DropUnwritten();

 private:
  std::vector<std::unique_ptr<Response>> responses_;
  std::vector<Response*> free_;
  std::deque<Outgoing> queue_;
  bool writing_ = false;  // the front of queue_
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_RESPONSE_QUEUE_H_
