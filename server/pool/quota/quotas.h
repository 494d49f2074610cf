#ifndef SERVER_POOL_QUOTA_QUOTAS_H_
#define SERVER_POOL_QUOTA_QUOTAS_H_

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
#include "server/pool/quota/limits.h"

namespace procgen {

// Resources that one owner uses or asks for.
struct Usage {
#define PROCGEN_MEMBER(name, what) int64_t name = 0;
  PROCGEN_QUOTAS(PROCGEN_MEMBER)
#undef PROCGEN_MEMBER
};

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

  explicit Quotas(const Limits& limits) : limits_(limits) {}
  Quotas(const Quotas&) = delete;
  Quotas& operator=(const Quotas&) = delete;

  // Adds `part` to the usage of `owner`. Errors: RESOURCE_EXHAUSTED a limit is exceeded; the
  // message contains owner, limit and values.
  absl::StatusOr<Reservation> Reserve(absl::string_view owner, const Usage& part);

  // Returns `value`, of `bytes` bytes, which counts as the owner's until its last reference
  // is dropped. Errors: as Reserve.
  template <typename Value>
  absl::StatusOr<std::shared_ptr<Value>> Hold(absl::string_view owner, int64_t bytes,
                                              std::shared_ptr<Value> value) {
    absl::StatusOr<Reservation> reservation = Reserve(owner, {.bytes = bytes});
    if (!reservation.ok()) {
      return reservation.status();
    }
    Value* const held = value.get();
    return std::shared_ptr<Value>(std::make_shared<std::pair<Reservation, std::shared_ptr<Value>>>(
                                      *std::move(reservation), std::move(value)),
                                  held);
  }

  // Environments of all owners.
  int64_t env_count() const;

 private:
  void Release(const std::string& owner, const Usage& part);

  const Limits limits_;
  mutable absl::Mutex mutex_;
  std::map<std::string, Usage, std::less<>> usage_by_owner_
      ABSL_GUARDED_BY(mutex_);  // without empty entries
  int64_t env_count_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen

#endif  // SERVER_POOL_QUOTA_QUOTAS_H_
