#include "server/pool/quota/quotas.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

// A limit of what one owner may hold.
struct Quota {
  int64_t Usage::*count;
  int64_t Limits::*max;
  absl::string_view counted;
  absl::string_view name;
};

constexpr Quota kQuotas[] = {
#define PROCGEN_QUOTA(name, what) \
  {&Usage::name, &Limits::owner_##name##_max, what, "owner_" #name "_max"},
    PROCGEN_QUOTAS(PROCGEN_QUOTA)
#undef PROCGEN_QUOTA
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
    const int64_t max = limits_.*quota.max;
    if (part.*quota.count > max - held.*quota.count) {
      return absl::ResourceExhaustedError(absl::StrCat(
          NameOf(owner), " has ", held.*quota.count, " ", quota.counted, " and asks for ",
          part.*quota.count, " more, limit ", quota.name, " is ", max));
    }
    sum.*quota.count = held.*quota.count + part.*quota.count;
  }
  if (part.env_count > limits_.env_count_max - env_count_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the server has ", env_count_, " environments and is asked for ",
                     part.env_count, " more, limit env_count_max is ", limits_.env_count_max));
  }
  env_count_ += part.env_count;
  usage_by_owner_[std::string(owner)] = sum;
  return Reservation(this, std::string(owner), part);
}

void Quotas::Release(const std::string& owner, const Usage& part) {
  absl::MutexLock lock(&mutex_);
  env_count_ -= part.env_count;
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

int64_t Quotas::env_count() const {
  absl::MutexLock lock(&mutex_);
  return env_count_;
}

}  // namespace procgen
