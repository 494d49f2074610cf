#include "server/fleet/pool/state_validator.h"

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "envcore/pool/pool_input.h"

namespace procgen {

absl::StatusOr<StateValidator> StateValidator::Create(const PoolOptions& options) {
  if (absl::Status status = CheckPoolOptions(options); !status.ok()) {
    return status;
  }
  PoolOptions model_options = options;
  model_options.env_count = static_cast<int32_t>(options.games.size());
  model_options.first_env = 0;
  model_options.total_env_count = 0;
  model_options.observation_format = {};
  absl::StatusOr<std::unique_ptr<Pool>> model =
      Pool::Create(model_options, std::make_shared<WorkerPool>(0));
  if (!model.ok()) {
    return model.status();
  }
  return StateValidator(options.first_env, *std::move(model));
}

absl::Status StateValidator::Check(const std::vector<v1::State>& states,
                                   std::vector<bool>* awaits_reset) {
  std::set<int32_t> seen;
  std::vector<bool> restored = *awaits_reset;
  for (const v1::State& state : states) {
    const int32_t environment = state.environment();
    if (absl::Status status = CheckEnvironment(environment, static_cast<int32_t>(restored.size()));
        !status.ok()) {
      return status;
    }
    if (!seen.insert(environment).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("environment ", environment, " is to be restored twice"));
    }
    const int32_t game = (first_env_ + environment) % model_->env_count();
    const absl::Status status = model_->RestoreStates({{game, state.snapshot()}});
    if (!status.ok()) {
      const absl::string_view message =
          absl::StripPrefix(status.message(), absl::StrCat("environment ", game, ": "));
      return {status.code(), absl::StrCat("environment ", environment, ": ", message)};
    }
    restored[static_cast<size_t>(environment)] = model_->AwaitsReset(game);
  }
  *awaits_reset = std::move(restored);
  return absl::OkStatus();
}

absl::Status CheckEnvironment(int32_t environment, int32_t env_count) {
  if (environment < 0 || environment >= env_count) {
    return absl::InvalidArgumentError(
        absl::StrCat("environment ", environment, " is not in [0, ", env_count, ")"));
  }
  return absl::OkStatus();
}

}  // namespace procgen
