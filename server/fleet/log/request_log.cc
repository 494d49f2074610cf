#include "server/fleet/log/request_log.h"

#include <algorithm>
#include <utility>

namespace procgen {

int64_t RequestLog::Append(Entry entry) {
  auto bytes = static_cast<int64_t>(entry->request.SpaceUsedLong());
  for (const v1::State& state : entry->states) {
    bytes += static_cast<int64_t>(state.SpaceUsedLong());
  }
  absl::MutexLock lock(&mutex_);
  byte_sums_.push_back((byte_sums_.empty() ? forgotten_bytes_ : byte_sums_.back()) + bytes);
  entries_.push_back(std::move(entry));
  const int64_t number = first_ + static_cast<int64_t>(entries_.size()) - 1;
  warmup_.Add(number, *entries_.back());
  return number;
}

void RequestLog::RemoveLast() {
  absl::MutexLock lock(&mutex_);
  entries_.pop_back();
  byte_sums_.pop_back();
  warmup_.Forget();
}

void RequestLog::ForgetUpTo(int64_t number) {
  absl::MutexLock lock(&mutex_);
  while (first_ <= number && !entries_.empty()) {
    forgotten_bytes_ = byte_sums_.front();
    entries_.pop_front();
    byte_sums_.pop_front();
    ++first_;
  }
}

RequestLog::Entry RequestLog::Find(int64_t number) const {
  absl::MutexLock lock(&mutex_);
  return entries_[static_cast<size_t>(number - first_)];
}

void RequestLog::BeginAfter(int64_t number) {
  absl::MutexLock lock(&mutex_);
  first_ = number + 1;
  if (number > 0) {
    warmup_.Forget();
  }
}

bool RequestLog::CanDrawFrom(Part range, int64_t number) const {
  absl::MutexLock lock(&mutex_);
  return warmup_.IsComplete(range, number);
}

int64_t RequestLog::end() const {
  absl::MutexLock lock(&mutex_);
  return first_ + static_cast<int64_t>(entries_.size()) - 1;
}

int64_t RequestLog::BytesAfter(int64_t number) const {
  absl::MutexLock lock(&mutex_);
  if (entries_.empty()) {
    return 0;
  }
  const int64_t before = number < first_
                             ? forgotten_bytes_
                             : byte_sums_[static_cast<size_t>(std::min(
                                   number - first_, static_cast<int64_t>(entries_.size()) - 1))];
  return byte_sums_.back() - before;
}

}  // namespace procgen
