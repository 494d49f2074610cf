#include "clients/libenv/handle.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "procgen_client/art_folders.h"

namespace procgen {

void Report(absl::string_view message) {
  const std::string line =
      absl::StrCat("libenv: ", absl::StrReplaceAll(message, {{"\n", " "}}), "\n");
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
}

}  // namespace procgen

namespace {

// Side of the human view in the infos, in pixels, and its bytes: uint8 [512, 512, 3].
constexpr int32_t kHumanViewSizePx = 512;
constexpr int32_t kHumanViewBytes = kHumanViewSizePx * kHumanViewSizePx * 3;

// Members of the info space, by index.
enum InfoMember : size_t {
  kInfoPrevLevelSeed = 0,
  kInfoPrevLevelComplete = 1,
  kInfoLevelSeed = 2,
  kInfoHumanView = 3,
};

LibenvTensorType Discrete(absl::string_view name, LibenvValueType value_type,
                          std::initializer_list<int> shape) {
  LibenvTensorType type = {};
  std::copy(name.begin(), name.end(), type.name);
  type.scalar_type = kLibenvDiscrete;
  type.value_type = value_type;
  std::copy(shape.begin(), shape.end(), type.shape);
  type.dimension_count = static_cast<int>(shape.size());
  return type;
}

LibenvTensorType Uint8(absl::string_view name, std::initializer_list<int> shape, uint8_t high) {
  LibenvTensorType type = Discrete(name, kLibenvUint8, shape);
  type.high.uint8 = high;
  return type;
}

LibenvTensorType Int32(absl::string_view name, int32_t high) {
  LibenvTensorType type = Discrete(name, kLibenvInt32, {});
  type.high.int32 = high;
  return type;
}

absl::Status CopyPointers(absl::string_view name, void* const* pointers, size_t count,
                          std::vector<void*>* copy) {
  if (pointers == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("buffers.", name, " is null"));
  }
  copy->assign(pointers, pointers + count);
  const auto null = std::find(copy->begin(), copy->end(), nullptr);
  return null == copy->end() ? absl::OkStatus()
                             : absl::InvalidArgumentError(absl::StrCat(
                                   "buffers.", name, "[", null - copy->begin(), "] is null"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<LibenvHandle>> LibenvHandle::Create(int env_count,
                                                                   const LibenvOptions& options) {
  auto made = procgen::ReadOptions(env_count, options);
  if (!made.ok()) {
    return made.status();
  }
  // Art that cannot be used is reported, and the built-in art is used in its place.
  const auto art = procgen_client::FindArt(made->resource_root);
  if (art.ok()) {
    made->pool.art = *art;
  }
  auto pool = procgen_client::LocalPool::Create(made->pool, made->num_threads);
  if (!pool.ok()) {
    return pool.status();
  }
  if (!art.ok()) {
    procgen::Report(
        absl::StrCat("using the built-in art; option resource_root: ", art.status().message()));
  }
  std::unique_ptr<LibenvHandle> handle(new LibenvHandle(*std::move(made), *std::move(pool)));
  if (absl::Status status = handle->Refresh(); !status.ok()) {
    return status;
  }
  return handle;
}

LibenvHandle::LibenvHandle(procgen::MakeOptions options, std::unique_ptr<procgen_client::Pool> pool)
    : options_(std::move(options)),
      observations_(static_cast<size_t>(options_.pool.env_count) * procgen::kObservationBytes),
      actions_(static_cast<size_t>(options_.pool.env_count)),
      pool_(std::move(pool)) {
  batch_.observations = absl::MakeSpan(observations_);
  batch_ = numbers_.ReplaceEmptyArrays(batch_, options_.pool.env_count);
}

std::vector<LibenvTensorType> LibenvHandle::TensorTypes(int space) const {
  constexpr uint8_t kColourMax = std::numeric_limits<uint8_t>::max();
  constexpr int32_t kSeedMax = std::numeric_limits<int32_t>::max();
  switch (space) {
    case kLibenvObservation:
      return {
          Uint8("rgb", {procgen::kObservationSizePx, procgen::kObservationSizePx, 3}, kColourMax)};
    case kLibenvAction:
      return {Int32("action", options_.num_actions - 1)};
    case kLibenvInfo: {
      std::vector<LibenvTensorType> infos = {Int32("prev_level_seed", kSeedMax),
                                             Uint8("prev_level_complete", {}, 1),
                                             Int32("level_seed", kSeedMax)};
      if (options_.render_human) {
        infos.push_back(Uint8("rgb", {kHumanViewSizePx, kHumanViewSizePx, 3}, kColourMax));
      }
      return infos;
    }
    default:
      return {};
  }
}

absl::Status LibenvHandle::SetBuffers(const LibenvBuffers& buffers) {
  const size_t count = actions_.size();
  const size_t info_count = count * (kInfoHumanView + (options_.render_human ? 1 : 0));
  std::vector<void*> observations;
  std::vector<void*> infos;
  std::vector<void*> actions;
  absl::Status status = CopyPointers("observations", buffers.observations, count, &observations);
  status.Update(CopyPointers("infos", buffers.infos, info_count, &infos));
  status.Update(CopyPointers("actions", buffers.actions, count, &actions));
  if (buffers.rewards == nullptr || buffers.firsts == nullptr) {
    status.Update(absl::InvalidArgumentError("buffers.rewards or buffers.firsts is null"));
  }
  if (status.ok()) {
    buffers_ = buffers;
    observation_buffers_ = std::move(observations);
    infos_ = std::move(infos);
    action_buffers_ = std::move(actions);
  }
  return status;
}

absl::Status LibenvHandle::Observe() {
  absl::Status status = CheckBuffers();
  if (status.ok()) {
    status = Wait();
  }
  for (int32_t i = 0; status.ok() && i < options_.pool.env_count; ++i) {
    status = Write(i);
  }
  return status;
}

absl::Status LibenvHandle::Act() {
  absl::Status status = CheckBuffers();
  if (status.ok()) {
    status = Wait();
  }
  if (!status.ok()) {
    return status;
  }
  for (size_t i = 0; i < actions_.size(); ++i) {
    std::memcpy(&actions_[i], action_buffers_[i], sizeof(actions_[i]));
    if (actions_[i] >= procgen::kEndEpisodeAction && actions_[i] < procgen::kActionCount) {
      continue;
    }
    if (!std::exchange(has_reported_action_, true)) {
      procgen::Report(absl::StrCat("action ", actions_[i], " of environment ", i, ", allowed: ",
                                   procgen::kEndEpisodeAction, " to ", procgen::kActionCount - 1,
                                   "; such actions do nothing, and are not reported again"));
    }
    actions_[i] = procgen::kNoAction;
  }
  const procgen::StepInput input = {.count = options_.pool.env_count, .actions = actions_};
  return pool_->thread_count() == 0 ? pool_->Step(input, /*annotations=*/{}, batch_)
                                    : pool_->Send(input, /*annotations=*/{}, batch_);
}

absl::StatusOr<int> LibenvHandle::SaveState(int environment, absl::Span<char> data) {
  absl::Status status = CheckEnvironment(environment);
  if (status.ok()) {
    status = Wait();
  }
  if (!status.ok()) {
    return status;
  }
  const auto snapshots = pool_->SaveStates({environment});
  if (!snapshots.ok()) {
    return snapshots.status();
  }
  const std::string& snapshot = snapshots->front();
  if (snapshot.size() > data.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("the snapshot has ", snapshot.size(), " bytes, the buffer has ", data.size()));
  }
  std::copy(snapshot.begin(), snapshot.end(), data.begin());
  return static_cast<int>(snapshot.size());
}

absl::Status LibenvHandle::RestoreState(int environment, absl::string_view snapshot) {
  absl::Status status = CheckEnvironment(environment);
  if (status.ok()) {
    status = Wait();
  }
  if (status.ok()) {
    status = pool_->RestoreStates({{.environment = environment, .snapshot = snapshot}});
  }
  if (status.ok()) {
    status = Refresh();
  }
  // Without buffers the first Observe writes it.
  return status.ok() && CheckBuffers().ok() ? Write(environment) : status;
}

absl::Status LibenvHandle::Wait() {
  return pool_->unanswered_count() == 0 ? absl::OkStatus()
                                        : pool_->Receive(std::chrono::duration<double>(-1));
}

absl::Status LibenvHandle::Refresh() {
  return pool_->Step({.count = options_.pool.env_count, .steps = false}, /*annotations=*/{},
                     batch_);
}

absl::Status LibenvHandle::Write(int32_t environment) {
  const auto i = static_cast<size_t>(environment);
  buffers_.rewards[i] = numbers_.rewards[i];
  buffers_.firsts[i] = numbers_.first[i];
  std::memcpy(observation_buffers_[i], &observations_[i * procgen::kObservationBytes],
              procgen::kObservationBytes);
  std::memcpy(Info(kInfoPrevLevelSeed, i), &numbers_.prev_level_seeds[i], sizeof(int32_t));
  std::memcpy(Info(kInfoPrevLevelComplete, i), &numbers_.prev_level_complete[i], 1);
  std::memcpy(Info(kInfoLevelSeed, i), &numbers_.level_seeds[i], sizeof(int32_t));
  if (!options_.render_human) {
    return absl::OkStatus();
  }
  auto* const view = static_cast<uint8_t*>(Info(kInfoHumanView, i));
  return pool_->Render(environment, kHumanViewSizePx, /*whole_level=*/false,
                       absl::MakeSpan(view, kHumanViewBytes));
}

absl::Status LibenvHandle::CheckBuffers() const {
  return buffers_.rewards != nullptr
             ? absl::OkStatus()
             : absl::FailedPreconditionError("no buffers are set, call libenv_set_buffers first");
}

absl::Status LibenvHandle::CheckEnvironment(int environment) const {
  if (environment < 0 || environment >= options_.pool.env_count) {
    return absl::InvalidArgumentError(
        absl::StrCat("environment ", environment, " is not in [0, ", options_.pool.env_count, ")"));
  }
  return absl::OkStatus();
}
