#ifndef SERVER_SESSION_QUOTA_QUOTAS_H_
#define SERVER_SESSION_QUOTA_QUOTAS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "server/session/quota/limits.h"

namespace procgen {

// Resources that one owner uses or asks for.
struct Usage {
  int64_t pool_count = 0;
  int64_t env_count = 0;
  int64_t stream_count = 0;
  int64_t call_count = 0;    // calls in progress, besides streams
  int64_t watch_count = 0;   // pools watched
  int64_t buffer_bytes = 0;  // requests, responses and level samplers
};

// Size above which a message counts as its owner's buffer: requests until they are answered,
// responses of unary calls until they are sent. Smaller ones are bounded by the number of calls. A
// step of 4,096 environments has about 4 KiB.
inline constexpr size_t kLargeMessageBytes = 32 << 10;

// Size from which a freed buffer triggers a trim of the heap.
inline constexpr int64_t kLargeBufferBytes = 1 << 20;

// The usage of each owner. An owner is a name that the transport assigns to a caller. Without
// authentication all callers are the owner "".
// Threads: any method from any thread; its lock is taken last, and nothing is called under it.
class Quotas {
 public:
  // A share of an owner's usage; released on destruction. `quotas` must outlive it.
  class Reservation {
   public:
    Reservation() = default;
    Reservation(Reservation&& other) noexcept;
    Reservation& operator=(Reservation&& other) noexcept;
    ~Reservation();

   private:
    friend class Quotas;
    Reservation(Quotas* quotas, std::string owner, const Usage& part);
    void Release();

    Quotas* quotas_ = nullptr;  // null: an empty reservation
    std::string owner_;
    Usage part_;
  };

  // `on_large_free`: called on any thread when kLargeBufferBytes or more are released.
  explicit Quotas(const Limits& limits, std::function<void()> on_large_free = nullptr)
      : limits_(limits), on_large_free_(std::move(on_large_free)) {}
  Quotas(const Quotas&) = delete;
  Quotas& operator=(const Quotas&) = delete;

  // Adds `part` to the usage of `owner`. Errors: RESOURCE_EXHAUSTED an owner limit is exceeded; the
  // message contains owner, limit and values.
  absl::StatusOr<Reservation> Reserve(absl::string_view owner, const Usage& part);

  // Returns `value`, of `bytes` bytes, which counts as the owner's buffer until its last reference
  // is dropped. Errors: as Reserve.
  template <typename Value>
  absl::StatusOr<std::shared_ptr<Value>> Hold(absl::string_view owner, int64_t bytes,
                                              std::shared_ptr<Value> value) {
    absl::StatusOr<Reservation> reservation = Reserve(owner, {.buffer_bytes = bytes});
    if (!reservation.ok()) {
      return reservation.status();
    }
    Value* const held = value.get();
    return std::shared_ptr<Value>(std::make_shared<std::pair<Reservation, std::shared_ptr<Value>>>(
                                      *std::move(reservation), std::move(value)),
                                  held);
  }

 private:
  void Release(const std::string& owner, const Usage& part);

  const Limits limits_;
  const std::function<void()> on_large_free_;
  absl::Mutex mutex_;
  std::map<std::string, Usage, std::less<>> usage_by_owner_
      ABSL_GUARDED_BY(mutex_);  // without empty entries
};

}  // namespace procgen

#endif  // SERVER_SESSION_QUOTA_QUOTAS_H_
