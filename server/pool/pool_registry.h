#ifndef SERVER_POOL_POOL_REGISTRY_H_
#define SERVER_POOL_POOL_REGISTRY_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "server/pool/pool_session.h"
#include "server/pool/quota/quotas.h"

namespace procgen {

// Pools by owner and name. Each owner has its own namespace: pools of other owners are not found,
// and their names are free.
// Threads: any method from any thread; none blocks. Its lock comes before those of PoolSession and
// Quotas, and no callback is called under it.
class PoolRegistry {
 public:
  using Key = std::pair<std::string, std::string>;  // owner, name
  struct Numbered {
    int64_t number = 0;  // >= 1, in order of creation
    std::shared_ptr<PoolSession> pool;
  };

  // Reserves the name `pools/ID` for a pool being created. An empty `id` means a generated number.
  // Errors: INVALID_ARGUMENT a malformed id; ALREADY_EXISTS.
  absl::StatusOr<Key> Reserve(absl::string_view owner, absl::string_view id,
                              Quotas::Reservation reservation);
  // Stores a created pool under its reserved name.
  void Put(const Key& key, std::shared_ptr<PoolSession> pool);

  // Errors: INVALID_ARGUMENT a malformed name; NOT_FOUND, also while the pool is being created.
  absl::StatusOr<std::shared_ptr<PoolSession>> Find(absl::string_view owner,
                                                    absl::string_view name) const;
  // Returns at most `count` pools of `owner` created after pool number `after` (0: all), oldest
  // first.
  std::vector<Numbered> List(absl::string_view owner, int64_t after, size_t count) const;
  // Returns the pools of all owners.
  std::vector<std::shared_ptr<PoolSession>> All() const;

  // Releases the name of a pool that could not be created.
  void Remove(const Key& key);
  // Returns false if it was removed before.
  bool Remove(const PoolSession& pool);
  void Clear();

 private:
  struct Entry {
    int64_t number = 0;
    Quotas::Reservation reservation;    // until it is removed
    std::shared_ptr<PoolSession> pool;  // null while it is being created
  };

  mutable absl::Mutex mutex_;
  std::map<Key, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  int64_t next_number_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace procgen

#endif  // SERVER_POOL_POOL_REGISTRY_H_
