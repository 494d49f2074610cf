#ifndef SERVER_SESSION_QUOTA_CAPACITY_H_
#define SERVER_SESSION_QUOTA_CAPACITY_H_

#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/session/quota/limits.h"

namespace procgen {

// The usage of all pools of a server together, within its limits.
// Threads: any method from any thread; its lock is taken last, and nothing is called under it.
class Capacity {
 public:
  // The capacity that one pool uses; released on destruction. `capacity` must outlive it.
  class Reservation {
   public:
    Reservation() = default;
    Reservation(Reservation&& other) noexcept;
    Reservation& operator=(Reservation&& other) noexcept;
    ~Reservation();

   private:
    friend class Capacity;
    Reservation(Capacity* capacity, int32_t env_count, int64_t observation_bytes)
        : capacity_(capacity), env_count_(env_count), observation_bytes_(observation_bytes) {}

    Capacity* capacity_ = nullptr;  // null: an empty reservation
    int32_t env_count_ = 0;
    int64_t observation_bytes_ = 0;
  };

  explicit Capacity(const Limits& limits) : limits_(limits) {}
  Capacity(const Capacity&) = delete;
  Capacity& operator=(const Capacity&) = delete;

  // Reserves capacity for a pool of `env_count` environments with observations of `frame_bytes`
  // bytes. Errors: INVALID_ARGUMENT no environment; RESOURCE_EXHAUSTED a limit is exceeded; the
  // message contains limit and values.
  absl::StatusOr<Reservation> Reserve(int32_t env_count, int64_t frame_bytes);
  // As Reserve, for a pool that exists already; also beyond limits that were lowered since.
  Reservation Count(int32_t env_count, int64_t frame_bytes);

  int32_t env_count() const;

 private:
  absl::Status Check(int32_t env_count, int64_t observation_bytes) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Reservation CountLocked(int32_t env_count, int64_t observation_bytes)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Limits limits_;
  mutable absl::Mutex mutex_;
  int32_t pool_count_ ABSL_GUARDED_BY(mutex_) = 0;
  int32_t env_count_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t observation_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // one observation of each environment
};

}  // namespace procgen

#endif  // SERVER_SESSION_QUOTA_CAPACITY_H_
