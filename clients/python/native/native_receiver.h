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

// Receives answers of a stream on a thread, one at a time, and signals an eventfd, for event loops.
// The thread never takes the GIL. Threads: Stop from any thread, the others one at a time.
class NativeReceiver {
 public:
  using Answer = std::pair<absl::Status, std::unique_ptr<procgen_client::Batch>>;

  // `take_batch` returns a batch to receive into; called on the thread.
  NativeReceiver(std::shared_ptr<procgen_client::StepStream> stream,
                 std::function<std::unique_ptr<procgen_client::Batch>()> take_batch);
  // Stops, and closes event_file(). REQUIRES: as Stop.
  ~NativeReceiver();
  NativeReceiver(const NativeReceiver&) = delete;
  NativeReceiver& operator=(const NativeReceiver&) = delete;

  // Ends the thread and releases the stream. An answer that is awaited arrives first, as an error.
  // event_file() stays open, because an event loop may be waiting for it. REQUIRES: the stream is
  // cancelled, or no answer is awaited.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);

  // Becomes readable when an answer has arrived. Owned by this object.
  int event_file() const { return event_file_; }
  // Starts to wait for the next answer. REQUIRES: the previous one was taken, and not stopped.
  void Begin();
  // Returns the answer. REQUIRES: event_file() is readable.
  Answer Take();

 private:
  void Run();

  std::shared_ptr<procgen_client::StepStream> stream_;  // null: stopped
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
