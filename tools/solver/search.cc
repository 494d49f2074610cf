#include "tools/solver/search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numbers>
#include <queue>
#include <string>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "envcore/environment/environment.h"
#include "envcore/games/game.h"
#include "envcore/random/random_stream.h"
#include "envcore/state/state_archive.h"
#include "tools/solver/goal_map.h"

namespace procgen {
namespace {

// The cost of a remaining target and of a tried burst, in cells to the goal.
constexpr float kCellsPerTarget = 100;
constexpr float kCellsPerBurst = 1;
// Of two paths to equally good places, the shorter one is followed first.
constexpr float kCellsPerStep = 0.01F;

// One level, played from any of its states. It is generated once, because that is slow; states are
// saved from it and restored into it.
class LevelPlayer {
 public:
  LevelPlayer(const GameSpec& spec, DistributionMode mode, int32_t level_seed)
      : step_limit_(spec.StepLimit(mode)) {
    GameOptions options;
    options.distribution_mode = mode;
    game_ = spec.make(options);
    game_->StartLevel(level_seed);
  }

  // REQUIRES: !outcome().done.
  void Play(int32_t action) { game_->Play(action); }
  std::string Save() {
    StateArchive archive;
    game_->VisitState(archive, step_limit_);
    return archive.Finish().value();
  }
  void Restore(const std::string& state) {
    StateArchive archive = StateArchive::Open(state).value();
    game_->VisitState(archive, step_limit_);
    if (!archive.Close().ok()) {
      std::abort();
    }
  }

  const StepOutcome& outcome() const { return game_->outcome(); }
  const World& world() const { return game_->world(); }
  int32_t step_number() const { return game_->step_number(); }
  // Step limit of an episode.
  int32_t step_limit() const { return step_limit_; }

 private:
  std::unique_ptr<Game> game_;
  int32_t step_limit_;
};

// States in one place count as equal: targets left, column, row, velocity (x, y), heading, time.
using Place = std::tuple<int32_t, int32_t, int32_t, int32_t, int32_t, int32_t, int32_t>;

// A reached state and the actions that lead to it.
struct Node {
  int32_t parent = -1;           // index; -1: the level's first step
  std::vector<int32_t> actions;  // from the parent to this node
  int32_t length = 0;            // steps from the level's first step
  GoalDistance distance;
  Place place;
  std::string state;
  int32_t burst_count = 0;  // bursts tried from this place
};

class Search {
 public:
  Search(const GameSpec& spec, const SearchHeuristic& heuristic, DistributionMode mode,
         int32_t level_seed)
      : heuristic_(heuristic),
        player_(spec, mode, level_seed),
        goal_map_(heuristic),
        random_(level_seed) {
    Remember(-1, {});
  }

  SearchResult Run(int64_t burst_count_max) {
    if (IsLostAtOnce()) {
      result_.verdict = Verdict::kLostAtOnce;
      return std::move(result_);
    }
    if (!nodes_.front().distance.has_way) {
      result_.verdict = Verdict::kClosedOff;
      return std::move(result_);
    }
    while (result_.verdict != Verdict::kSolved && result_.burst_count < burst_count_max) {
      const int32_t index = queue_.top().second;
      queue_.pop();
      Node& node = nodes_[static_cast<size_t>(index)];
      if (best_[node.place] != index) {
        node.state.clear();  // a shorter path to this place was found
        continue;
      }
      ++node.burst_count;
      ++result_.burst_count;
      Burst(index);
      Enqueue(index);
    }
    return std::move(result_);
  }

 private:
  // Whether every first action ends the level without completing it.
  bool IsLostAtOnce() {
    for (int32_t action = 0; action < kActionCount; ++action) {
      player_.Restore(nodes_.front().state);
      player_.Play(action);
      ++result_.step_count;
      if (!player_.outcome().done || player_.outcome().level_complete) {
        return false;
      }
    }
    return true;
  }

  // Tries random actions from a node.
  void Burst(int32_t index) {
    player_.Restore(nodes_[static_cast<size_t>(index)].state);
    std::vector<int32_t> actions;
    while (static_cast<int32_t>(actions.size()) < heuristic_.burst_steps) {
      const int32_t choice = random_.Int(static_cast<int32_t>(heuristic_.actions.size()));
      const int32_t action = heuristic_.actions[static_cast<size_t>(choice)];
      const int32_t hold_steps = 1 + random_.Int(heuristic_.hold_steps_max);
      for (int32_t step = 0; step < hold_steps; ++step) {
        player_.Play(action);
        actions.push_back(action);
        ++result_.step_count;
        if (player_.outcome().level_complete) {
          result_.verdict = Verdict::kSolved;
          result_.actions = ActionsTo(index, actions);
          return;
        }
        if (player_.outcome().done || player_.step_number() >= player_.step_limit()) {
          return;
        }
      }
      Remember(index, actions);
    }
  }

  // Adds the player's state as a node, unless its place is already known with a path of at most
  // this length.
  void Remember(int32_t parent, const std::vector<int32_t>& actions) {
    Node node;
    node.parent = parent;
    node.actions = actions;
    node.length = player_.step_number();
    node.distance = goal_map_.From(player_.world());
    node.place = PlaceOf(node.distance.targets_left);
    const auto index = static_cast<int32_t>(nodes_.size());
    const auto [known, is_new] = best_.try_emplace(node.place, index);
    if (!is_new) {
      const Node& former = nodes_[static_cast<size_t>(known->second)];
      if (former.length <= node.length) {
        return;
      }
      node.burst_count = former.burst_count;
      known->second = index;
    }
    node.state = player_.Save();
    nodes_.push_back(std::move(node));
    Enqueue(index);
  }

  Place PlaceOf(int32_t targets_left) const {
    const Entity& agent = player_.world().agent();
    const auto bin = [](float value, float unit) {
      return unit > 0 ? static_cast<int32_t>(std::floor(value / unit + 0.5F)) : 0;
    };
    const auto places = static_cast<float>(heuristic_.places_per_cell);
    const auto heading_count = static_cast<float>(heuristic_.heading_count);
    const float turns = agent.rotation / (2 * std::numbers::pi_v<float>);
    const int32_t heading = bin((turns - std::floor(turns)) * heading_count, 1);
    const int32_t period =
        heuristic_.period_steps > 0 ? player_.step_number() / heuristic_.period_steps : 0;
    return {targets_left,
            static_cast<int32_t>(std::floor(agent.x * places)),
            static_cast<int32_t>(std::floor(agent.y * places)),
            bin(agent.vx, heuristic_.velocity_unit),
            bin(agent.vy, heuristic_.velocity_unit),
            heading % heuristic_.heading_count,
            period};
  }

  void Enqueue(int32_t index) {
    const Node& node = nodes_[static_cast<size_t>(index)];
    const float cost = static_cast<float>(node.distance.targets_left) * kCellsPerTarget +
                       static_cast<float>(node.distance.cells) +
                       static_cast<float>(node.burst_count) * kCellsPerBurst +
                       static_cast<float>(node.length) * kCellsPerStep;
    queue_.emplace(cost, index);
  }

  // The actions from the level's first step to a node, followed by `last`.
  std::vector<int32_t> ActionsTo(int32_t index, const std::vector<int32_t>& last) const {
    std::vector<int32_t> backward(last.rbegin(), last.rend());
    while (index >= 0) {
      const Node& node = nodes_[static_cast<size_t>(index)];
      backward.insert(backward.end(), node.actions.rbegin(), node.actions.rend());
      index = node.parent;
    }
    std::reverse(backward.begin(), backward.end());
    return backward;
  }

  const SearchHeuristic& heuristic_;
  LevelPlayer player_;
  GoalMap goal_map_;
  RandomStream random_;
  SearchResult result_;
  std::vector<Node> nodes_;
  absl::flat_hash_map<Place, int32_t> best_;  // node of each place
  // Cost and node; lowest cost first, then the older node.
  std::priority_queue<std::pair<float, int32_t>, std::vector<std::pair<float, int32_t>>,
                      std::greater<>>
      queue_;
};

}  // namespace

SearchResult SearchLevel(const GameSpec& spec, const SearchHeuristic& heuristic,
                         DistributionMode mode, int32_t level_seed, int64_t burst_count_max) {
  return Search(spec, heuristic, mode, level_seed).Run(burst_count_max);
}

bool CompletesLevel(const GameSpec& spec, DistributionMode mode, int32_t level_seed,
                    const std::vector<int32_t>& actions) {
  EnvironmentOptions options;
  options.distribution_mode = mode;
  options.num_levels = 1;
  options.start_level = level_seed;
  Environment environment(spec, ResolveOptions(spec.name, options).value(),
                          /*level_stream_seed=*/0, AutoresetMode::kNextStep);
  const StepResult& result = environment.result();
  for (size_t i = 0; i < actions.size(); ++i) {
    environment.Step(actions[i], /*repeat=*/1, [] {});
    const bool ended = result.terminated || result.truncated;
    if (ended) {
      return i + 1 == actions.size() && result.terminated && result.prev_level_complete &&
             result.prev_level_seed == level_seed;
    }
  }
  return false;
}

}  // namespace procgen
