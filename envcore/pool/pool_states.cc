#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "envcore/pool/frame_stack.h"
#include "envcore/pool/pool.h"

namespace procgen {
namespace {

constexpr absl::string_view kTaken =
    "another call steps or reads this pool; retry when it has returned";

Status NamedTwice(int32_t environment) {
  return InvalidArgumentError(
      absl::StrCat("environment ", environment, " is to be restored twice"));
}

// Adds the environment's index to an error.
Status OfEnvironment(int32_t environment, const Status& status) {
  return {status.code(), absl::StrCat("environment ", environment, ": ", status.message())};
}

}  // namespace

Status Pool::CheckIndex(int32_t environment) const {
  if (environment < 0 || environment >= env_count()) {
    return InvalidArgumentError(
        absl::StrCat("environment ", environment, " is not in [0, ", env_count(), ")"));
  }
  return OkStatus();
}

StatusOr<std::vector<std::string>> Pool::SaveStates(absl::Span<const int32_t> environments) {
  if (!Take()) {
    return procgen::AbortedError(kTaken);
  }
  auto snapshots = SaveTaken(environments);
  Release();
  return snapshots;
}

Status Pool::RestoreStates(absl::Span<const StateToRestore> states) {
  if (!Take()) {
    return procgen::AbortedError(kTaken);
  }
  Status status = RestoreTaken(states);
  Release();
  return status;
}

Status Pool::CloneStates(absl::Span<const StateToClone> pairs) {
  std::vector<int32_t> sources;
  for (const StateToClone& pair : pairs) {
    sources.push_back(pair.source_environment);
  }
  if (!Take()) {
    return procgen::AbortedError(kTaken);
  }
  const auto snapshots = SaveTaken(sources);
  Status status = snapshots.status();
  if (status.ok()) {
    std::vector<StateToRestore> states;
    for (size_t i = 0; i < pairs.size(); ++i) {
      states.push_back({.environment = pairs[i].target_environment, .snapshot = (*snapshots)[i]});
    }
    status = RestoreTaken(states);
  }
  Release();
  return status;
}

StatusOr<std::vector<std::string>> Pool::SaveTaken(absl::Span<const int32_t> environments) {
  std::vector<std::string> snapshots;
  for (const int32_t index : environments) {
    if (Status status = CheckIndex(index); !status.ok()) {
      return status;
    }
    StatusOr<std::string> snapshot = environments_[static_cast<size_t>(index)]->SaveState();
    if (!snapshot.ok()) {
      return OfEnvironment(index, snapshot.status());
    }
    snapshots.push_back(*std::move(snapshot));
  }
  return snapshots;
}

Status Pool::RestoreTaken(absl::Span<const StateToRestore> states) {
  std::set<int32_t> had;
  std::vector<std::unique_ptr<Environment>> restored;
  for (const StateToRestore& state : states) {
    if (Status status = CheckIndex(state.environment); !status.ok()) {
      return status;
    }
    if (!had.insert(state.environment).second) {
      return NamedTwice(state.environment);
    }
    const GameSpec& spec = environments_[static_cast<size_t>(state.environment)]->spec();
    auto environment = Environment::Restore(spec, state.snapshot, options_.autoreset_mode);
    if (!environment.ok()) {
      return OfEnvironment(state.environment, environment.status());
    }
    restored.push_back(*std::move(environment));
  }
  for (size_t i = 0; i < states.size(); ++i) {
    const auto index = static_cast<size_t>(states[i].environment);
    environments_[index] = std::move(restored[i]);
    environments_[index]->SetLevelSampler(level_sampler_);
    if (!frame_stacks_.empty()) {
      frame_stacks_[index].Clear();
    }
  }
  return OkStatus();
}

}  // namespace procgen
