#include "server/pool/turn_queue.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {

void TurnQueue::Take(Begin begin) {
  absl::Status status;
  {
    absl::MutexLock lock(&mutex_);
    if (!closed_.ok()) {
      status = closed_;
    } else if (!is_taken_) {
      is_taken_ = true;
    } else if (waiting_.size() < kTurnsWaitingMax) {
      waiting_.push_back(std::move(begin));
      return;
    } else {
      status = absl::ResourceExhaustedError(absl::StrCat(
          waiting_.size(), " calls wait for pool ", pool_name_, ", allowed: ", kTurnsWaitingMax));
    }
  }
  begin(status);
}

void TurnQueue::End() {
  Begin begin;
  {
    absl::MutexLock lock(&mutex_);
    if (waiting_.empty()) {
      is_taken_ = false;
      return;
    }
    begin = std::move(waiting_.front());
    waiting_.pop_front();
  }
  begin(absl::OkStatus());
}

std::deque<TurnQueue::Begin> TurnQueue::Close(const absl::Status& reason) {
  std::deque<Begin> waiting;
  absl::MutexLock lock(&mutex_);
  closed_ = reason;
  waiting.swap(waiting_);
  return waiting;
}

}  // namespace procgen
