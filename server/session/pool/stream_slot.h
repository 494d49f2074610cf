#ifndef SERVER_SESSION_POOL_STREAM_SLOT_H_
#define SERVER_SESSION_POOL_STREAM_SLOT_H_

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "server/concurrency/deadline_timer.h"
#include "server/session/pool/attach_options.h"
#include "server/session/pool/resume_buffer.h"
#include "server/session/quota/quotas.h"

namespace procgen {

// Why a stream must end.
enum class StreamEnd : uint8_t {
  kDrain,      // the server will stop
  kTakenOver,  // another stream waits for the pool
  kClosed,     // the pool is gone
};

// The stream attached to a pool, and the lease, which runs while none is. At most one stream is
// attached; another may take over. After Close none attaches.
// Threads: any method from any thread. Lock order: mutex_ before that of the ResumeBuffer.
class StreamSlot {
 public:
  // Notifies a stream that it must end and with which status. Called at most once, and not after
  // Detach.
  using EndStream = absl::AnyInvocable<void(StreamEnd, absl::Status)>;
  using Done = absl::AnyInvocable<void(absl::Status)>;

  // The pool that it belongs to, and its dependencies, which must outlive this.
  struct Context {
    std::string owner;
    std::string pool_name;
    Quotas* quotas = nullptr;
    DeadlineTimer* lease_timer = nullptr;
    ResumeBuffer* resume_buffer = nullptr;
    const std::atomic<int64_t>* next_sequence_number = nullptr;
  };

  // The lease begins now; infinite: no lease.
  StreamSlot(Context context, absl::Duration lease_duration);

  // As the methods of PoolSession.
  void Attach(const AttachOptions& options, EndStream end_stream, Done done);
  void Detach();
  void End(StreamEnd why, const absl::Status& reason);
  absl::Status Renew(std::optional<absl::Duration> lease_duration);

  // Rejects new streams with `reason`. The attached stream is notified by EndAll.
  void Close(const absl::Status& reason);
  // As Close. Returns false and changes nothing if it was closed before.
  bool CloseIfOpen(const absl::Status& reason);
  // Closes if the lease expired by `now`. Returns false if it has not, or if a stream is attached.
  bool CloseIfExpired(absl::Time now, const absl::Status& reason);
  // Ends the attached stream and the waiting one.
  void EndAll(const absl::Status& reason);

  bool attached() const;
  bool closed() const;
  absl::Duration lease_duration() const;
  // When the lease expires. InfiniteFuture while a stream is attached, and without a lease.
  absl::Time expire_time() const;

 private:
  // A stream that waits for the attached one to detach.
  struct Successor {
    AttachOptions options;
    EndStream end_stream;
    Done done;
  };

  absl::Status CheckAttach(const AttachOptions& options) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void BeginStream(const AttachOptions& options, EndStream end_stream)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void BeginLease() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Context context_;

  mutable absl::Mutex mutex_;
  bool attached_ ABSL_GUARDED_BY(mutex_) = false;
  Quotas::Reservation stream_reservation_
      ABSL_GUARDED_BY(mutex_);                    // while attached; passes to the successor
  EndStream end_stream_ ABSL_GUARDED_BY(mutex_);  // null once called
  std::optional<Successor> successor_ ABSL_GUARDED_BY(mutex_);
  absl::Duration lease_duration_ ABSL_GUARDED_BY(mutex_);
  absl::Time expire_time_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);  // OK while open
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_STREAM_SLOT_H_
