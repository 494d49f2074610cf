#include "clients/libenv/host_buffers.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "envcore/pool/pool.h"

namespace procgen {
namespace {

absl::Status CopyPointers(absl::string_view name, void* const* pointers, size_t count,
                          std::vector<void*>* copy) {
  if (pointers == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("buffers.", name, " is null"));
  }
  copy->assign(pointers, pointers + count);
  for (size_t i = 0; i < count; ++i) {
    if (pointers[i] == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat("buffers.", name, "[", i, "] is null"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<HostBuffers> HostBuffers::Create(const LibenvBuffers& buffers, int32_t env_count,
                                                bool render_human) {
  HostBuffers made;
  made.env_count_ = static_cast<size_t>(env_count);
  const size_t info_count =
      made.env_count_ * static_cast<size_t>(kInfoHumanView + (render_human ? 1 : 0));
  absl::Status status =
      CopyPointers("observations", buffers.observations, made.env_count_, &made.observations_);
  status.Update(CopyPointers("infos", buffers.infos, info_count, &made.infos_));
  status.Update(CopyPointers("actions", buffers.actions, made.env_count_, &made.actions_));
  if (buffers.rewards == nullptr || buffers.firsts == nullptr) {
    status.Update(absl::InvalidArgumentError("buffers.rewards or buffers.firsts is null"));
  }
  if (!status.ok()) {
    return status;
  }
  made.rewards_ = buffers.rewards;
  made.firsts_ = buffers.firsts;
  return made;
}

void HostBuffers::ReadActions(absl::Span<int32_t> actions) const {
  for (size_t i = 0; i < env_count_; ++i) {
    std::memcpy(&actions[i], actions_[i], sizeof(actions[i]));
  }
}

void HostBuffers::Write(const EnvironmentValues& observed) const {
  for (size_t i = 0; i < env_count_; ++i) {
    WriteOne(i, observed);
  }
}

void HostBuffers::WriteOne(size_t i, const EnvironmentValues& observed) const {
  rewards_[i] = observed.rewards[i];
  firsts_[i] = observed.first[i];
  std::memcpy(observations_[i], &observed.observations[i * kObservationBytes], kObservationBytes);
  std::memcpy(Info(kInfoPrevLevelSeed, i), &observed.prev_level_seeds[i], sizeof(int32_t));
  std::memcpy(Info(kInfoPrevLevelComplete, i), &observed.prev_level_complete[i], sizeof(uint8_t));
  std::memcpy(Info(kInfoLevelSeed, i), &observed.level_seeds[i], sizeof(int32_t));
}

absl::Span<uint8_t> HostBuffers::HumanView(int32_t environment) const {
  return {static_cast<uint8_t*>(Info(kInfoHumanView, static_cast<size_t>(environment))),
          kHumanViewBytes};
}

}  // namespace procgen
