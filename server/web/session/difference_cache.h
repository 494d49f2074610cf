#ifndef SERVER_WEB_SESSION_DIFFERENCE_CACHE_H_
#define SERVER_WEB_SESSION_DIFFERENCE_CACHE_H_

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/synchronization/mutex.h"

namespace procgen::web {

// The newest compressed differences between frames. Pages that show the same environments share
// them, because compression is the largest part of a page's cost. Memory: kBytesMax.
// Threads: any method from any thread.
class DifferenceCache {
 public:
  static constexpr size_t kBytesMax = 4 << 20;

  // Hashes (64 bits) of the previous frame and of the frame.
  using Key = std::pair<size_t, size_t>;

  std::optional<std::string> Find(const Key& key) const ABSL_LOCKS_EXCLUDED(mutex_);
  void Add(const Key& key, const std::string& difference) ABSL_LOCKS_EXCLUDED(mutex_);
  size_t count() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  mutable absl::Mutex mutex_;
  absl::flat_hash_map<Key, std::string> differences_ ABSL_GUARDED_BY(mutex_);
  std::deque<Key> oldest_first_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_DIFFERENCE_CACHE_H_
