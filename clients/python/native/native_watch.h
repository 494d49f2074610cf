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

// The latest message of a watch. A thread reads all of them, so that a slow reader misses those in
// between and buffers, which have room for megabytes, stay empty.
class NativeWatch {
 public:
  // `next` waits for a message and serialises it, `stop` ends such a wait, from any thread.
  NativeWatch(std::function<absl::StatusOr<std::string>()> next, std::function<void()> stop,
              std::shared_ptr<std::atomic<bool>> is_client_closed);
  ~NativeWatch();
  NativeWatch(const NativeWatch&) = delete;
  NativeWatch& operator=(const NativeWatch&) = delete;

  // Waits for a message that was not returned before. Raises the error that the watch ended with;
  // StopIteration after Close.
  pybind11::bytes Next();
  void Close();

 private:
  // What the thread and the reader share, also while the thread outlives a forked child's reader.
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
