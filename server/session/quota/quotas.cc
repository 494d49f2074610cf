#include "server/session/quota/quotas.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

// A limit of what one owner may hold.
struct Quota {
  int64_t Usage::*count;
  int64_t (*max)(const Limits& limits);
  absl::string_view counted;
  absl::string_view name;
};

constexpr Quota kQuotas[] = {
    {&Usage::pool_count,
     [](const Limits& limits) -> int64_t { return limits.owner_pool_count_max; }, "pools",
     "owner_pool_count_max"},
    {&Usage::env_count, [](const Limits& limits) -> int64_t { return limits.owner_env_count_max; },
     "environments", "owner_env_count_max"},
    {&Usage::stream_count,
     [](const Limits& limits) -> int64_t { return limits.owner_stream_count_max; }, "streams",
     "owner_stream_count_max"},
    {&Usage::call_count,
     [](const Limits& limits) -> int64_t { return limits.owner_call_count_max; }, "calls under way",
     "owner_call_count_max"},
    {&Usage::watch_count,
     [](const Limits& limits) -> int64_t { return limits.owner_watch_count_max; }, "watches",
     "owner_watch_count_max"},
    {&Usage::buffer_bytes, [](const Limits& limits) { return limits.owner_buffer_bytes_max; },
     "bytes of requests, responses and level samplers", "owner_buffer_bytes_max"},
};

std::string NameOf(absl::string_view owner) {
  return owner.empty() ? "every caller together" : absl::StrCat("owner ", owner);
}

}  // namespace

Quotas::Reservation::Reservation(Quotas* quotas, std::string owner, const Usage& part)
    : quotas_(quotas), owner_(std::move(owner)), part_(part) {}

Quotas::Reservation::Reservation(Reservation&& other) noexcept
    : quotas_(std::exchange(other.quotas_, nullptr)),
      owner_(std::move(other.owner_)),
      part_(other.part_) {}

Quotas::Reservation& Quotas::Reservation::operator=(Reservation&& other) noexcept {
  if (this != &other) {
    Release();
    quotas_ = std::exchange(other.quotas_, nullptr);
    owner_ = std::move(other.owner_);
    part_ = other.part_;
  }
  return *this;
}

Quotas::Reservation::~Reservation() { Release(); }

void Quotas::Reservation::Release() {
  if (quotas_ != nullptr) {
    std::exchange(quotas_, nullptr)->Release(owner_, part_);
  }
}

absl::StatusOr<Quotas::Reservation> Quotas::Reserve(absl::string_view owner, const Usage& part) {
  absl::MutexLock lock(&mutex_);
  const auto found = usage_by_owner_.find(owner);
  const Usage held = found == usage_by_owner_.end() ? Usage() : found->second;
  Usage sum;
  for (const Quota& quota : kQuotas) {
    const int64_t max = quota.max(limits_);
    if (part.*quota.count > max - held.*quota.count) {
      return absl::ResourceExhaustedError(absl::StrCat(
          NameOf(owner), " has ", held.*quota.count, " ", quota.counted, " and asks for ",
          part.*quota.count, " more, limit ", quota.name, " is ", max));
    }
    sum.*quota.count = held.*quota.count + part.*quota.count;
  }
  usage_by_owner_[std::string(owner)] = sum;
  return Reservation(this, std::string(owner), part);
}

void Quotas::Release(const std::string& owner, const Usage& part) {
  {
    absl::MutexLock lock(&mutex_);
    const auto found = usage_by_owner_.find(owner);
    bool is_empty = true;
    for (const Quota& quota : kQuotas) {
      found->second.*quota.count -= part.*quota.count;
      is_empty = is_empty && found->second.*quota.count == 0;
    }
    if (is_empty) {
      usage_by_owner_.erase(found);
    }
  }
  if (part.buffer_bytes >= kLargeBufferBytes && on_large_free_ != nullptr) {
    on_large_free_();
  }
}

}  // namespace procgen
