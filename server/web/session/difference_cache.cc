#include "server/web/session/difference_cache.h"

namespace procgen::web {

std::optional<std::string> DifferenceCache::Find(const Key& key) const {
  const absl::MutexLock lock(&mutex_);
  const auto found = differences_.find(key);
  return found == differences_.end() ? std::nullopt : std::make_optional(found->second);
}

void DifferenceCache::Add(const Key& key, const std::string& difference) {
  const absl::MutexLock lock(&mutex_);
  if (!differences_.try_emplace(key, difference).second) {
    return;  // another page was as fast
  }
  oldest_first_.push_back(key);
  bytes_ += sizeof(Key) + difference.size();
  while (bytes_ > kBytesMax) {
    const auto oldest = differences_.find(oldest_first_.front());
    bytes_ -= sizeof(Key) + oldest->second.size();
    differences_.erase(oldest);
    oldest_first_.pop_front();
  }
}

size_t DifferenceCache::count() const {
  const absl::MutexLock lock(&mutex_);
  return differences_.size();
}

}  // namespace procgen::web
