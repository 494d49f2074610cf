#ifndef SERVER_RPC_STEP_REQUEST_WINDOW_H_
#define SERVER_RPC_STEP_REQUEST_WINDOW_H_

#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "server/wire/convert_step.h"

namespace procgen {

// The requests of a stream that are not answered yet: at most as many as there are slots. While all
// are taken nothing is read, so a learner that does not read its answers is not read either.
//
// The way of a slot: free, being read into, taken in, in the inbox, carried out (Next), free.
// Threads: compatible.
class RequestWindow {
 public:
  // With one slot, for attach.
  RequestWindow();
  // Has `slot_count` slots from now on, at least as many as before.
  void Grow(size_t slot_count);

  // Whether another request may be read.
  bool CanRead() const;
  void BeginRead();
  // The read that is under way, if one is, will bring nothing.
  void AbandonRead();
  // What was read, to be taken in; null: nothing was, or nothing is wanted any more.
  StreamRequest* EndRead(bool ok);
  // Puts what was taken in into the inbox (unless nothing is wanted any more), or forgets it.
  void TakeIn(StreamRequest* request);
  void EndTakingIn() { taking_in_ = false; }

  // The next to be carried out; null: none.
  StreamRequest* Next();
  // Its last answer is on its way.
  void Free(StreamRequest* request) { free_.push_back(request); }

  void StopReading() { reading_ended_ = true; }
  // Stops reading, and forgets the inbox.
  void Stop();
  // No request will be carried out any more.
  bool IsOver() const { return reading_ended_ && !taking_in_ && inbox_.empty(); }

  // The slot of attach, the first request.
  StreamRequest* front() { return slots_.front().get(); }

 private:
  std::vector<std::unique_ptr<StreamRequest>> slots_;
  std::vector<StreamRequest*> free_;
  std::deque<StreamRequest*> inbox_;
  StreamRequest* reading_ = nullptr;  // what a read fills, or null
  bool taking_in_ = false;            // what was read
  bool reading_ended_ = false;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_REQUEST_WINDOW_H_
