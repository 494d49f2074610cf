#include "server/pool/request_pause.h"

#include <utility>

namespace procgen {

void RequestPause::Pause() {
  absl::MutexLock lock(&mutex_);
  ++pause_count_;
}

void RequestPause::EndPause() {
  {
    absl::MutexLock lock(&mutex_);
    if (--pause_count_ == 0) {
      passes_left_ = 0;
    }
  }
  Wake();
}

void RequestPause::PassOne() {
  {
    absl::MutexLock lock(&mutex_);
    if (pause_count_ == 0) {
      return;
    }
    ++passes_left_;
  }
  Wake();
}

void RequestPause::PassStream() {
  {
    absl::MutexLock lock(&mutex_);
    passes_stream_ = true;
  }
  Wake();
}

void RequestPause::Pass(Begin begin) {
  if (!paused()) {
    begin();
    return;
  }
  {
    absl::MutexLock lock(&mutex_);
    waiting_ = std::move(begin);
  }
  Wake();
}

void RequestPause::Wake() {
  Begin begin;
  {
    absl::MutexLock lock(&mutex_);
    if (waiting_ == nullptr || !MayPass()) {
      return;
    }
    if (pause_count_ > 0 && !passes_stream_) {
      --passes_left_;
    }
    std::swap(begin, waiting_);
  }
  begin();
}

}  // namespace procgen
