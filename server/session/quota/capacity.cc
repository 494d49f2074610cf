#include "server/session/quota/capacity.h"

#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace procgen {

Capacity::Reservation::Reservation(Reservation&& other) noexcept
    : capacity_(std::exchange(other.capacity_, nullptr)),
      env_count_(other.env_count_),
      observation_bytes_(other.observation_bytes_) {}

Capacity::Reservation& Capacity::Reservation::operator=(Reservation&& other) noexcept {
  std::swap(capacity_, other.capacity_);
  std::swap(env_count_, other.env_count_);
  std::swap(observation_bytes_, other.observation_bytes_);
  return *this;
}

Capacity::Reservation::~Reservation() {
  if (capacity_ != nullptr) {
    absl::MutexLock lock(&capacity_->mutex_);
    --capacity_->pool_count_;
    capacity_->env_count_ -= env_count_;
    capacity_->observation_bytes_ -= observation_bytes_;
  }
}

absl::StatusOr<Capacity::Reservation> Capacity::Reserve(int32_t env_count, int64_t frame_bytes) {
  const int64_t observation_bytes = env_count * frame_bytes;
  absl::MutexLock lock(&mutex_);
  if (absl::Status status = Check(env_count, observation_bytes); !status.ok()) {
    return status;
  }
  return CountLocked(env_count, observation_bytes);
}

Capacity::Reservation Capacity::Count(int32_t env_count, int64_t frame_bytes) {
  absl::MutexLock lock(&mutex_);
  return CountLocked(env_count, env_count * frame_bytes);
}

Capacity::Reservation Capacity::CountLocked(int32_t env_count, int64_t observation_bytes) {
  ++pool_count_;
  env_count_ += env_count;
  observation_bytes_ += observation_bytes;
  return {this, env_count, observation_bytes};
}

absl::Status Capacity::Check(int32_t env_count, int64_t observation_bytes) const {
  if (env_count < 1) {
    return absl::InvalidArgumentError(absl::StrCat("spec.env_count is ", env_count,
                                                   ", allowed: 1 to ", limits_.pool_env_count_max));
  }
  if (env_count > limits_.pool_env_count_max) {
    return absl::ResourceExhaustedError(absl::StrCat("spec.env_count is ", env_count,
                                                     ", limit pool_env_count_max is ",
                                                     limits_.pool_env_count_max));
  }
  if (env_count > limits_.env_count_max - env_count_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("spec.env_count is ", env_count, " and there are ", env_count_,
                     " environments, limit env_count_max is ", limits_.env_count_max));
  }
  if (observation_bytes > limits_.observation_bytes_max - observation_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("one observation of each environment takes ", observation_bytes,
                     " bytes and those of other pools ", observation_bytes_,
                     ", limit observation_bytes_max is ", limits_.observation_bytes_max));
  }
  if (pool_count_ >= limits_.pool_count_max) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "there are ", pool_count_, " pools, limit pool_count_max is ", limits_.pool_count_max));
  }
  return absl::OkStatus();
}

int32_t Capacity::env_count() const {
  absl::MutexLock lock(&mutex_);
  return env_count_;
}

}  // namespace procgen
