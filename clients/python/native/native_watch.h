#ifndef CLIENTS_PYTHON_NATIVE_NATIVE_WATCH_H_
#define CLIENTS_PYTHON_NATIVE_NATIVE_WATCH_H_

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "clients/python/native/process_owner.h"
#include "pybind11/pybind11.h"

namespace procgen_python {

// A server stream conflated to the latest message. A thread reads all messages, so a slow reader
// skips intermediate ones and gRPC's buffers of several megabytes stay empty.
class NativeWatch {
 public:
  // `next` waits for a message and serialises it; `stop` ends the wait, from any thread.
  NativeWatch(std::function<absl::StatusOr<std::string>()> next, std::function<void()> stop,
              std::shared_ptr<std::atomic<bool>> is_client_closed);
  ~NativeWatch();  // NOLINT(bugprone-exception-escape)
  NativeWatch(const NativeWatch&) = delete;
  NativeWatch& operator=(const NativeWatch&) = delete;

  // Waits for a message that was not returned before. Raises the error that ended the stream, or
  // StopIteration after Close.
  pybind11::bytes Next();
  void Close();

 private:
  // State shared by the thread and the reader.
  struct Newest {
    absl::Mutex mutex;
    std::optional<std::string> message ABSL_GUARDED_BY(mutex);
    absl::Status end ABSL_GUARDED_BY(mutex);
  };

  const ProcessOwner owner_;
  const std::shared_ptr<std::atomic<bool>> is_client_closed_;
  std::function<void()> stop_;
  std::shared_ptr<Newest> newest_ = std::make_shared<Newest>();
  bool is_closed_ = false;
  std::unique_ptr<std::thread> reader_;
};

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_NATIVE_WATCH_H_
