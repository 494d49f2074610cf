#include "server/session/quota/owners.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

// A limit of what one owner may hold.
struct Quota {
  int64_t Holding::*count;
  int64_t (*max)(const Limits& limits);
  absl::string_view counted;
  absl::string_view name;
};

constexpr Quota kQuotas[] = {
    {&Holding::pool_count,
     [](const Limits& limits) -> int64_t { return limits.owner_pool_count_max; }, "pools",
     "owner_pool_count_max"},
    {&Holding::env_count,
     [](const Limits& limits) -> int64_t { return limits.owner_env_count_max; }, "environments",
     "owner_env_count_max"},
    {&Holding::stream_count,
     [](const Limits& limits) -> int64_t { return limits.owner_stream_count_max; }, "streams",
     "owner_stream_count_max"},
    {&Holding::call_count,
     [](const Limits& limits) -> int64_t { return limits.owner_call_count_max; }, "calls under way",
     "owner_call_count_max"},
    {&Holding::watch_count,
     [](const Limits& limits) -> int64_t { return limits.owner_watch_count_max; }, "watches",
     "owner_watch_count_max"},
    {&Holding::buffer_bytes, [](const Limits& limits) { return limits.owner_buffer_bytes_max; },
     "bytes of requests, responses and level samplers", "owner_buffer_bytes_max"},
};

std::string NameOf(absl::string_view owner) {
  return owner.empty() ? "every caller together" : absl::StrCat("owner ", owner);
}

}  // namespace

Owners::Share::Share(Owners* owners, std::string owner, const Holding& part)
    : owners_(owners), owner_(std::move(owner)), part_(part) {}

Owners::Share::Share(Share&& other) noexcept
    : owners_(std::exchange(other.owners_, nullptr)),
      owner_(std::move(other.owner_)),
      part_(other.part_) {}

Owners::Share& Owners::Share::operator=(Share&& other) noexcept {
  if (this != &other) {
    GiveBack();
    owners_ = std::exchange(other.owners_, nullptr);
    owner_ = std::move(other.owner_);
    part_ = other.part_;
  }
  return *this;
}

Owners::Share::~Share() { GiveBack(); }

void Owners::Share::GiveBack() {
  if (owners_ != nullptr) {
    std::exchange(owners_, nullptr)->GiveBack(owner_, part_);
  }
}

absl::StatusOr<Owners::Share> Owners::Take(absl::string_view owner, const Holding& part) {
  absl::MutexLock lock(&mutex_);
  const auto found = holdings_.find(owner);
  const Holding held = found == holdings_.end() ? Holding() : found->second;
  Holding sum;
  for (const Quota& quota : kQuotas) {
    const int64_t max = quota.max(limits_);
    if (part.*quota.count > max - held.*quota.count) {
      return absl::ResourceExhaustedError(absl::StrCat(
          NameOf(owner), " has ", held.*quota.count, " ", quota.counted, " and asks for ",
          part.*quota.count, " more, limit ", quota.name, " is ", max));
    }
    sum.*quota.count = held.*quota.count + part.*quota.count;
  }
  holdings_[std::string(owner)] = sum;
  return Share(this, std::string(owner), part);
}

void Owners::GiveBack(const std::string& owner, const Holding& part) {
  {
    absl::MutexLock lock(&mutex_);
    const auto found = holdings_.find(owner);
    bool is_empty = true;
    for (const Quota& quota : kQuotas) {
      found->second.*quota.count -= part.*quota.count;
      is_empty = is_empty && found->second.*quota.count == 0;
    }
    if (is_empty) {
      holdings_.erase(found);
    }
  }
  if (part.buffer_bytes >= kLargeBufferBytes && on_large_free_ != nullptr) {
    on_large_free_();
  }
}

}  // namespace procgen
