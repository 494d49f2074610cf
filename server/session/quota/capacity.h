#ifndef SERVER_SESSION_QUOTA_CAPACITY_H_
#define SERVER_SESSION_QUOTA_CAPACITY_H_

#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/session/quota/limits.h"

namespace procgen {

// What the pools of all owners take of a server together, within its limits.
// Threads: any method from any thread; its lock is taken last, and nothing is called under it.
class Capacity {
 public:
  // What one pool takes, given back when this goes. `capacity` must outlive it.
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

    Capacity* capacity_ = nullptr;  // null: nothing is taken
    int32_t env_count_ = 0;
    int64_t observation_bytes_ = 0;
  };

  explicit Capacity(const Limits& limits) : limits_(limits) {}
  Capacity(const Capacity&) = delete;
  Capacity& operator=(const Capacity&) = delete;

  // Takes room for a pool of `env_count` environments, whose observations have `frame_bytes` bytes.
  // Errors: INVALID_ARGUMENT no environment; RESOURCE_EXHAUSTED more than one of the limits; the
  // message names limit and values.
  absl::StatusOr<Reservation> Reserve(int32_t env_count, int64_t frame_bytes);
  // For a pool that exists, also beyond limits that have become less since it was made.
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
  int64_t observation_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // of one observation of each
};

}  // namespace procgen

#endif  // SERVER_SESSION_QUOTA_CAPACITY_H_
