#ifndef SERVER_RPC_STEP_REQUEST_WINDOW_H_
#define SERVER_RPC_STEP_REQUEST_WINDOW_H_

#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "server/wire/convert_step.h"

namespace procgen {

// The unanswered requests of a stream, in a fixed number of slots. No request is read while all
// slots are in use, so a learner that does not read its answers is stopped by flow control.
//
// States of a slot: free, reading, parsing, in the inbox, executing (Next), free.
// Threads: compatible.
class RequestWindow {
 public:
  // Has one slot, for attach.
  RequestWindow();
  // Increases the number of slots to `slot_count`.
  void Grow(size_t slot_count);

  // Whether another request may be read.
  bool CanRead() const;
  void BeginRead();
  // Frees the slot of the current read, which will return no request. No effect without a read.
  void AbandonRead();
  // Ends the read and returns its request, which is then parsed. Null if not `ok`, or if reading
  // has stopped.
  StreamRequest* EndRead(bool ok);
  // Ends parsing and appends `request` to the inbox; drops it if reading has stopped.
  void Enqueue(StreamRequest* request);
  // Ends parsing of a request that does not enter the inbox.
  void EndParse() { parsing_ = false; }

  // Removes and returns the first request of the inbox; null: none.
  StreamRequest* Next();
  // Frees the slot of an answered request.
  void Free(StreamRequest* request) { free_.push_back(request); }

  void StopReading() { reading_ended_ = true; }
  // Stops reading and clears the inbox.
  void Stop();
  // Whether Next will return no further request.
  bool IsOver() const { return reading_ended_ && !parsing_ && inbox_.empty(); }

  // The slot of attach, the first request.
  StreamRequest* front() { return slots_.front().get(); }

 private:
  std::vector<std::unique_ptr<StreamRequest>> slots_;
  std::vector<StreamRequest*> free_;
  std::deque<StreamRequest*> inbox_;
  StreamRequest* reading_ = nullptr;  // the slot of the current read; null: none
  bool parsing_ = false;              // a request was read and is not in the inbox yet
  bool reading_ended_ = false;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_REQUEST_WINDOW_H_
