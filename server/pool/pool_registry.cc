#include "server/pool/pool_registry.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace procgen {
namespace {

constexpr size_t kPoolIdLengthMax = 63;
constexpr absl::string_view kNamePrefix = "pools/";

bool IsPoolId(absl::string_view id, bool leading_digit_allowed) {
  if (id.empty() || id.size() > kPoolIdLengthMax || id.back() == '-') {
    return false;
  }
  const bool starts_well =
      absl::ascii_islower(static_cast<unsigned char>(id.front())) ||
      (leading_digit_allowed && absl::ascii_isdigit(static_cast<unsigned char>(id.front())));
  return starts_well && std::all_of(id.begin(), id.end(), [](unsigned char letter) {
           return absl::ascii_islower(letter) || absl::ascii_isdigit(letter) || letter == '-';
         });
}

absl::Status CheckName(absl::string_view name) {
  absl::string_view id = name;
  if (!absl::ConsumePrefix(&id, kNamePrefix) || !IsPoolId(id, true)) {
    return absl::InvalidArgumentError(
        absl::StrCat("pool name is '", name.substr(0, 2 * kPoolIdLengthMax),
                     "', allowed: 'pools/ID', with an ID of 1 to 63 of a-z, 0-9 and '-'"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PoolRegistry::Key> PoolRegistry::Reserve(absl::string_view owner,
                                                        absl::string_view id,
                                                        Quotas::Reservation reservation) {
  if (!id.empty() && !IsPoolId(id, false)) {
    return absl::InvalidArgumentError(
        absl::StrCat("pool_id is '", id.substr(0, 2 * kPoolIdLengthMax),
                     "', allowed: 1 to 63 of a-z, 0-9 and '-', beginning with a letter and not "
                     "ending in '-'"));
  }
  absl::MutexLock lock(&mutex_);
  Key key(owner,
          id.empty() ? absl::StrCat(kNamePrefix, next_number_) : absl::StrCat(kNamePrefix, id));
  if (!entries_.try_emplace(key, Entry{next_number_, std::move(reservation), nullptr}).second) {
    return absl::AlreadyExistsError(
        absl::StrCat("pool ", key.second, " exists; choose another pool_id"));
  }
  ++next_number_;
  return key;
}

void PoolRegistry::Put(const Key& key, std::shared_ptr<PoolSession> pool) {
  absl::MutexLock lock(&mutex_);
  entries_.find(key)->second.pool = std::move(pool);
}

absl::StatusOr<std::shared_ptr<PoolSession>> PoolRegistry::Find(absl::string_view owner,
                                                                absl::string_view name) const {
  if (absl::Status status = CheckName(name); !status.ok()) {
    return status;
  }
  absl::MutexLock lock(&mutex_);
  const auto entry = entries_.find(Key(owner, name));
  if (entry == entries_.end() || entry->second.pool == nullptr) {
    return absl::NotFoundError(absl::StrCat("there is no pool ", name));
  }
  return entry->second.pool;
}

std::vector<PoolRegistry::Numbered> PoolRegistry::List(absl::string_view owner, int64_t after,
                                                       size_t count) const {
  std::vector<Numbered> listed;
  {
    absl::MutexLock lock(&mutex_);
    for (auto it = entries_.lower_bound(Key(owner, ""));
         it != entries_.end() && it->first.first == owner; ++it) {
      const Entry& entry = it->second;
      if (entry.pool != nullptr && entry.number > after) {
        listed.push_back({entry.number, entry.pool});
      }
    }
  }
  std::sort(listed.begin(), listed.end(),
            [](const Numbered& left, const Numbered& right) { return left.number < right.number; });
  if (listed.size() > count) {
    listed.resize(count);
  }
  return listed;
}

std::vector<std::shared_ptr<PoolSession>> PoolRegistry::All() const {
  std::vector<std::shared_ptr<PoolSession>> pools;
  absl::MutexLock lock(&mutex_);
  pools.reserve(entries_.size());
  for (const auto& [key, entry] : entries_) {
    if (entry.pool != nullptr) {
      pools.push_back(entry.pool);
    }
  }
  return pools;
}

void PoolRegistry::Remove(const Key& key) {
  absl::MutexLock lock(&mutex_);
  entries_.erase(key);
}

bool PoolRegistry::Remove(const PoolSession& pool) {
  std::shared_ptr<PoolSession> removed;  // freed outside the lock
  absl::MutexLock lock(&mutex_);
  const auto entry = entries_.find(Key(pool.owner(), pool.name()));
  if (entry == entries_.end() || entry->second.pool.get() != &pool) {
    return false;
  }
  removed = std::move(entry->second.pool);
  entries_.erase(entry);
  return true;
}

void PoolRegistry::Clear() {
  std::map<Key, Entry> removed;  // freed outside the lock
  absl::MutexLock lock(&mutex_);
  removed.swap(entries_);
}

}  // namespace procgen
