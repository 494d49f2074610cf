#ifndef CLIENTS_PYTHON_NATIVE_NATIVE_RECEIVER_H_
#define CLIENTS_PYTHON_NATIVE_NATIVE_RECEIVER_H_

#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "procgen_client/batch.h"
#include "procgen_client/step_stream.h"

namespace procgen_python {

// Waits for answers of a stream on a thread, one at a time, and makes an eventfd readable when one
// is there: what an event loop waits for. The thread never takes the GIL. Threads: one at a time.
class NativeReceiver {
 public:
  using Answer = std::pair<absl::Status, std::unique_ptr<procgen_client::Batch>>;

  // `take_batch` gives a batch to receive into, from any thread.
  NativeReceiver(std::shared_ptr<procgen_client::StepStream> stream,
                 std::function<std::unique_ptr<procgen_client::Batch>()> take_batch);
  // Waits for the thread, which ends when the stream is cancelled or has nothing to wait for.
  ~NativeReceiver();
  NativeReceiver(const NativeReceiver&) = delete;
  NativeReceiver& operator=(const NativeReceiver&) = delete;

  // Becomes readable when there is an answer. Belongs to this.
  int event_file() const { return event_file_; }
  // Waits for the next answer from now on. REQUIRES: the last one was taken.
  void Begin();
  // The answer. REQUIRES: event_file() is readable.
  Answer Take();

 private:
  void Run();

  const std::shared_ptr<procgen_client::StepStream> stream_;
  const std::function<std::unique_ptr<procgen_client::Batch>()> take_batch_;
  const int event_file_;
  absl::Mutex mutex_;
  bool is_wanted_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_ended_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<Answer> answer_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_NATIVE_RECEIVER_H_
