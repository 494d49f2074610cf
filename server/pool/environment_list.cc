#include "server/pool/environment_list.h"

#include <vector>

#include "absl/strings/str_cat.h"

namespace procgen {

absl::Status CheckEnvironmentList(const EnvironmentList& list, absl::string_view pool,
                                  int32_t env_count) {
  if (list.environments.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(list.list, " is empty, allowed: at least one"));
  }
  std::vector<bool> seen(static_cast<size_t>(env_count), false);
  for (size_t i = 0; i < list.environments.size(); ++i) {
    const int32_t environment = list.environments[i];
    if (environment < 0 || environment >= env_count) {
      return absl::InvalidArgumentError(absl::StrCat(list.list, "[", i, "]", list.member, " is ",
                                                     environment, ", pool ", pool,
                                                     " has environments 0 to ", env_count - 1));
    }
    const auto index = static_cast<size_t>(environment);
    if (seen[index] && !list.repeats_allowed) {
      return absl::InvalidArgumentError(absl::StrCat(list.list, "[", i, "]", list.member, " is ",
                                                     environment,
                                                     " again, allowed: each at most once"));
    }
    seen[index] = true;
  }
  return absl::OkStatus();
}

}  // namespace procgen
