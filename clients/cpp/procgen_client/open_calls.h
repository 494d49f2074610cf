#ifndef PROCGEN_CLIENT_OPEN_CALLS_H_
#define PROCGEN_CLIENT_OPEN_CALLS_H_

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <utility>

namespace procgen_client {

// The calls of a connection, which Close ends, so that those who wait for them return.
// Threads: any method from any thread.
class OpenCalls {
 public:
  // A call that is open as long as this exists.
  class Entry {
   public:
    // `cancel` is called by Close, or here if the connection is closed already. It must not block.
    Entry(std::shared_ptr<OpenCalls> calls, std::function<void()> cancel)
        : calls_(std::move(calls)) {
      const std::lock_guard lock(calls_->mutex_);
      if (calls_->is_closed_) {
        cancel();
      }
      place_ = calls_->cancels_.insert(calls_->cancels_.end(), std::move(cancel));
    }
    ~Entry() {
      const std::lock_guard lock(calls_->mutex_);
      calls_->cancels_.erase(place_);
    }
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;

   private:
    const std::shared_ptr<OpenCalls> calls_;
    std::list<std::function<void()>>::iterator place_;
  };

  // Ends all calls with CANCELLED, also later ones.
  void Close() {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
    for (const std::function<void()>& cancel : cancels_) {
      cancel();
    }
  }
  bool is_closed() const {
    const std::lock_guard lock(mutex_);
    return is_closed_;
  }

 private:
  mutable std::mutex mutex_;
  bool is_closed_ = false;                    // under mutex_
  std::list<std::function<void()>> cancels_;  // under mutex_
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_OPEN_CALLS_H_
