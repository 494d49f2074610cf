#include "tests/benchmark/measuring/action_script.h"

#include <random>

#include "envcore/games/game_options.h"

namespace procgen {
namespace {

// A prime, so that no episode length divides it.
constexpr size_t kRows = 1009;

}  // namespace

ActionScript::ActionScript(int32_t env_count)
    : env_count_(static_cast<size_t>(env_count)), actions_(kRows * env_count_) {
  std::mt19937 random(1);
  for (int32_t& action : actions_) {
    action = static_cast<int32_t>(random() % kActionCount);
  }
}

absl::Span<const int32_t> ActionScript::Next() {
  row_ = (row_ + 1) % kRows;
  return absl::MakeConstSpan(actions_).subspan(row_ * env_count_, env_count_);
}

}  // namespace procgen
