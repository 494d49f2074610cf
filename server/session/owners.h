#ifndef SERVER_SESSION_OWNERS_H_
#define SERVER_SESSION_OWNERS_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "server/session/limits.h"

namespace procgen {

// What one owner has at a time, or asks for.
struct Holding {
  int32_t pool_count = 0;
  int32_t environment_count = 0;
  int32_t stream_count = 0;
  int32_t call_count = 0;   // calls under way, besides streams
  int32_t watch_count = 0;  // pools watched
};

// Who holds how much of the server. An owner is a name, which whoever knows the caller gives; where
// nobody is asked who they are, all are the owner "".
// Threads: any method from any thread; its lock is taken last, and nothing is called under it.
class Owners {
 public:
  // A part of what an owner holds, given back when this goes. `owners` must outlive it.
  class Share {
   public:
    Share() = default;
    Share(Share&& other) noexcept;
    Share& operator=(Share&& other) noexcept;
    ~Share();

   private:
    friend class Owners;
    Share(Owners* owners, std::string owner, const Holding& part);
    void GiveBack();

    Owners* owners_ = nullptr;  // null: nothing is held
    std::string owner_;
    Holding part_;
  };

  explicit Owners(const Limits& limits) : limits_(limits) {}
  Owners(const Owners&) = delete;
  Owners& operator=(const Owners&) = delete;

  // Adds `part` to what `owner` holds. Errors: RESOURCE_EXHAUSTED more than one of the owner's
  // limits; the message names owner, limit and values.
  absl::StatusOr<Share> Take(absl::string_view owner, const Holding& part);

 private:
  void GiveBack(const std::string& owner, const Holding& part);

  const Limits limits_;
  absl::Mutex mutex_;
  std::map<std::string, Holding, std::less<>> holdings_ ABSL_GUARDED_BY(mutex_);  // none is empty
};

}  // namespace procgen

#endif  // SERVER_SESSION_OWNERS_H_
