#include "server/pool/request.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

absl::Status CheckSlice(absl::string_view pool, int32_t env_count, const Request& request) {
  if (request.first < 0 || request.first >= env_count) {
    return absl::InvalidArgumentError(absl::StrCat("slice.first_env is ", request.first, ", pool ",
                                                   pool, " has environments 0 to ", env_count - 1));
  }
  if (request.count < 1 || request.count > env_count - request.first) {
    return absl::InvalidArgumentError(
        absl::StrCat("slice.env_count is ", request.count, ", allowed from environment ",
                     request.first, " of pool ", pool, " on: 1 to ", env_count - request.first));
  }
  return absl::OkStatus();
}

absl::Status CheckActions(absl::string_view pool, const Request& request) {
  if (request.actions.size() != static_cast<size_t>(request.count)) {
    return absl::InvalidArgumentError(absl::StrCat("actions has ", request.actions.size(),
                                                   " entries, the slice of pool ", pool, " has ",
                                                   request.count, " environments"));
  }
  for (size_t i = 0; i < request.actions.size(); ++i) {
    const int32_t action = request.actions[i];
    if (action < kEndEpisodeAction || action >= kActionCount) {
      return absl::InvalidArgumentError(absl::StrCat("actions[", i, "] is ", action, ", allowed: ",
                                                     kEndEpisodeAction, " to ", kActionCount - 1));
    }
  }
  if (request.repeat < 1 || request.repeat > kRepeatMax) {
    return absl::InvalidArgumentError(
        absl::StrCat("repeat_count is ", request.repeat, ", allowed: 1 to ", kRepeatMax));
  }
  return absl::OkStatus();
}

// Checks that each element of `list` is an environment of the slice, and that none repeats.
template <typename Element>
absl::Status CheckEnvironments(absl::string_view list_name, absl::Span<const Element> list,
                               const Request& request) {
  if (list.empty()) {
    return absl::OkStatus();
  }
  std::vector<bool> seen(static_cast<size_t>(request.count), false);
  for (size_t i = 0; i < list.size(); ++i) {
    const int32_t environment = list[i].environment;
    const int32_t last = request.first + request.count - 1;
    if (environment < request.first || environment > last) {
      return absl::InvalidArgumentError(absl::StrCat(list_name, "[", i, "].environment is ",
                                                     environment, ", the slice is ", request.first,
                                                     " to ", last));
    }
    const auto row = static_cast<size_t>(environment - request.first);
    if (seen[row]) {
      return absl::InvalidArgumentError(absl::StrCat(list_name, "[", i, "].environment is ",
                                                     environment,
                                                     " again, allowed: each at most once"));
    }
    seen[row] = true;
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckRequest(absl::string_view pool, int32_t env_count, const Request& request) {
  if (request.kind == Request::Kind::kSample) {
    return absl::OkStatus();
  }
  if (absl::Status status = CheckSlice(pool, env_count, request); !status.ok()) {
    return status;
  }
  if (request.kind == Request::Kind::kStep) {
    absl::Status status = CheckActions(pool, request);
    status.Update(CheckAnnotations(request.annotations, request.count));
    if (!status.ok()) {
      return status;
    }
  }
  if (request.kind == Request::Kind::kReset && request.resets.empty()) {
    return absl::InvalidArgumentError("resets is empty, allowed: at least one environment");
  }
  if (absl::Status status = CheckEnvironments("next_levels", request.next_levels, request);
      !status.ok()) {
    return status;
  }
  return CheckEnvironments("resets", request.resets, request);
}

}  // namespace procgen
