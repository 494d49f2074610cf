#include "clients/python/native/native_watch.h"

#include <utility>

#include "absl/time/time.h"
#include "clients/python/native/python_error.h"
#include "procgen_client/cancellation.h"

namespace procgen_python {

namespace py = pybind11;

NativeWatch::NativeWatch(std::function<absl::StatusOr<std::string>()> next,
                         std::function<void()> stop,
                         std::shared_ptr<std::atomic<bool>> is_client_closed)
    : is_client_closed_(std::move(is_client_closed)), stop_(std::move(stop)) {
  reader_ = std::make_unique<std::thread>([next = std::move(next), latest = newest_] {
    absl::Status end;
    while (end.ok()) {
      absl::StatusOr<std::string> message = next();
      absl::MutexLock lock(&latest->mutex);
      if (message.ok()) {
        latest->message = *std::move(message);
      } else {
        end = latest->end = message.status();
      }
    }
  });
}

// NOLINTNEXTLINE(bugprone-exception-escape): only without a Python interpreter
NativeWatch::~NativeWatch() {
  if (!owner_.is_this_process()) {
    static_cast<void>(reader_.release());  // the thread does not exist in the child
    Leak(std::move(stop_));
    return;
  }
  Close();
}

py::bytes NativeWatch::Next() {
  if (is_closed_) {
    throw py::stop_iteration();
  }
  procgen_client::Cancellation cancellation(
      [this] { return *is_client_closed_ || SignalHandlerRaised(); });
  std::optional<std::string> message;
  const absl::Status end = WithoutGil([&] {
    absl::MutexLock lock(&newest_->mutex);
    const auto is_there = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(newest_->mutex) {
      return newest_->message.has_value() || !newest_->end.ok();
    };
    while (!newest_->mutex.AwaitWithTimeout(absl::Condition(&is_there),
                                            procgen_client::kCancellationInterval)) {
      newest_->mutex.Unlock();
      const bool is_cancelled = cancellation.Check();
      newest_->mutex.Lock();
      if (is_cancelled) {
        return absl::CancelledError("the connection was closed by this client");
      }
    }
    message = std::exchange(newest_->message, std::nullopt);
    return message.has_value() ? absl::OkStatus() : newest_->end;
  });
  Check(end);
  return *message;
}

void NativeWatch::Close() {
  if (std::exchange(is_closed_, true)) {
    return;
  }
  WithoutGil([&] {
    stop_();
    reader_->join();
    return 0;
  });
}

}  // namespace procgen_python
