#include "clients/libenv/handle.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/libenv/report.h"
#include "procgen_client/art_folders.h"

namespace {

// Uses the art folder that the host names. If it cannot be used, that is reported, and the built-in
// art is used in its place.
absl::StatusOr<std::unique_ptr<procgen::Environments>> MakeEnvironments(
    const procgen::MakeOptions& options) {
  procgen::PoolOptions pool = options.pool;
  const auto art = procgen_client::FindArt(options.resource_root);
  if (art.ok()) {
    pool.art = *art;
  }
  auto environments = procgen::Environments::Create(pool, options.num_threads);
  if (environments.ok() && !art.ok()) {
    procgen::Report(
        absl::StrCat("using the built-in art; option resource_root: ", art.status().message()));
  }
  return environments;
}

}  // namespace

absl::StatusOr<std::unique_ptr<LibenvHandle>> LibenvHandle::Create(int env_count,
                                                                   const LibenvOptions& options) {
  auto made = procgen::ReadOptions(env_count, options);
  if (!made.ok()) {
    return made.status();
  }
  auto environments = MakeEnvironments(*made);
  if (!environments.ok()) {
    return environments.status();
  }
  return std::unique_ptr<LibenvHandle>(new LibenvHandle(*made, *std::move(environments)));
}

LibenvHandle::LibenvHandle(const procgen::MakeOptions& options,
                           std::unique_ptr<procgen::Environments> environments)
    : options_(options),
      environments_(std::move(environments)),
      actions_(static_cast<size_t>(options.pool.env_count)) {}

std::vector<LibenvTensorType> LibenvHandle::TensorTypes(int space) const {
  return procgen::TensorTypesOf(space, options_.num_actions, options_.render_human);
}

absl::Status LibenvHandle::SetBuffers(const LibenvBuffers& buffers) {
  auto made = procgen::HostBuffers::Create(buffers, options_.pool.env_count, options_.render_human);
  if (!made.ok()) {
    return made.status();
  }
  buffers_ = *std::move(made);
  return absl::OkStatus();
}

absl::Status LibenvHandle::Observe() {
  if (!buffers_.has_value()) {
    return absl::FailedPreconditionError("no buffers are set, call libenv_set_buffers first");
  }
  const auto observed = environments_->Observe();
  if (!observed.ok()) {
    return observed.status();
  }
  buffers_->Write(*observed);
  for (int32_t i = 0; options_.render_human && i < options_.pool.env_count; ++i) {
    if (absl::Status status = environments_->Render(i, buffers_->HumanView(i)); !status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

absl::Status LibenvHandle::Act() {
  if (!buffers_.has_value()) {
    return absl::FailedPreconditionError("no buffers are set, call libenv_set_buffers first");
  }
  buffers_->ReadActions(absl::MakeSpan(actions_));
  CheckActions();
  return environments_->Act(actions_);
}

void LibenvHandle::CheckActions() {
  for (size_t i = 0; i < actions_.size(); ++i) {
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
}

absl::StatusOr<int> LibenvHandle::SaveState(int environment, absl::Span<char> data) {
  if (absl::Status status = CheckEnvironment(environment); !status.ok()) {
    return status;
  }
  const auto snapshot = environments_->SaveState(environment);
  if (!snapshot.ok()) {
    return snapshot.status();
  }
  if (snapshot->size() > data.size()) {
    return absl::InvalidArgumentError(absl::StrCat("the snapshot has ", snapshot->size(),
                                                   " bytes, the buffer has ", data.size()));
  }
  std::copy(snapshot->begin(), snapshot->end(), data.begin());
  return static_cast<int>(snapshot->size());
}

absl::Status LibenvHandle::RestoreState(int environment, absl::string_view snapshot) {
  if (absl::Status status = CheckEnvironment(environment); !status.ok()) {
    return status;
  }
  if (absl::Status status = environments_->RestoreState(environment, snapshot); !status.ok()) {
    return status;
  }
  if (!buffers_.has_value()) {
    return absl::OkStatus();  // the first Observe writes it
  }
  const auto observed = environments_->Observe();
  if (!observed.ok()) {
    return observed.status();
  }
  buffers_->WriteOne(static_cast<size_t>(environment), *observed);
  if (options_.render_human) {
    return environments_->Render(environment, buffers_->HumanView(environment));
  }
  return absl::OkStatus();
}

absl::Status LibenvHandle::CheckEnvironment(int environment) const {
  if (environment < 0 || environment >= options_.pool.env_count) {
    return absl::InvalidArgumentError(
        absl::StrCat("environment ", environment, " is not in [0, ", options_.pool.env_count, ")"));
  }
  return absl::OkStatus();
}
