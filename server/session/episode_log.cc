#include "server/session/episode_log.h"

#include <algorithm>
#include <bit>
#include <map>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

// A pool's memory: so much for each environment, and then some. The longest episodes have 6,000
// steps, and two of them are kept.
constexpr int64_t kEnvironmentBytesMax = 20 << 10;
constexpr int64_t kPoolBytesMin = 1 << 20;
// Rows of a run, by the bytes of its actions.
constexpr int64_t kRunActionBytes = 64 << 10;
constexpr int64_t kRunRowsMin = 16;
constexpr int64_t kRunRowsMax = 1024;
// Of different slices that are stepped in turn.
constexpr size_t kOpenRunsMax = 64;

int64_t RowsMaxOf(Part slice) {
  return std::clamp(kRunActionBytes / slice.count, kRunRowsMin, kRunRowsMax);
}

// What a run takes in memory.
int64_t BytesOf(const StepRun& run) {
  return static_cast<int64_t>(sizeof(StepRun) + run.numbers.capacity() * sizeof(int64_t) +
                              run.actions.capacity() + run.counts.capacity() * sizeof(uint16_t) +
                              run.rewards.capacity() * sizeof(StepRun::Reward) +
                              run.later_levels.capacity() * sizeof(StepRun::Level));
}

size_t PlaceOf(int32_t environment) { return static_cast<size_t>(environment); }

// A step that one environment took, in a run.
struct TakenStep {
  const StepRun* run = nullptr;
  size_t index = 0;
  float reward = 0;
  std::optional<int32_t> later_level;
};
using TakenSteps = std::map<int64_t, TakenStep>;  // by number: slices may be stepped in turn

// Adds the steps of `run` with numbers in (begin, end], as `environment` took them.
void AddSteps(const StepRun& run, int64_t begin, int64_t end, int32_t environment,
              TakenSteps* steps) {
  for (size_t i = 0; i < run.numbers.size(); ++i) {
    if (run.numbers[i] > begin && run.numbers[i] <= end) {
      (*steps)[run.numbers[i]] = {&run, i, 0, std::nullopt};
    }
  }
  const auto of_step = [&](int32_t step, int32_t whose) -> TakenStep* {
    const auto found = steps->find(run.numbers[static_cast<size_t>(step)]);
    return whose == environment && found != steps->end() ? &found->second : nullptr;
  };
  for (const StepRun::Reward& reward : run.rewards) {
    if (TakenStep* step = of_step(reward.step, reward.environment); step != nullptr) {
      step->reward = reward.reward;
    }
  }
  for (const StepRun::Level& level : run.later_levels) {
    if (TakenStep* step = of_step(level.step, level.environment); step != nullptr) {
      step->later_level = level.level_seed;
    }
  }
}

}  // namespace

Episode EpisodeLog::Pieces::Join() const {
  TakenSteps steps;
  for (const std::shared_ptr<const StepRun>& run : runs_) {
    AddSteps(*run, begin_, end_, environment_, &steps);
  }
  Episode episode = episode_;
  bool repeats = false;
  for (const auto& [number, step] : steps) {
    const StepRun& run = *step.run;
    const size_t at = step.index * static_cast<size_t>(run.slice.count) +
                      static_cast<size_t>(environment_ - run.slice.first);
    const size_t count = run.counts.empty() ? 1 : run.counts[at];
    episode.actions.append(count, static_cast<char>(run.actions[at]));
    episode.rewards.push_back(step.reward);
    episode.action_counts.push_back(static_cast<int32_t>(count));
    repeats = repeats || count != 1;
    if (step.later_level.has_value()) {
      episode.later_levels.push_back(
          {static_cast<int32_t>(episode.actions.size()) - 1, *step.later_level});
    }
  }
  if (!repeats) {
    episode.action_counts.clear();
  }
  return episode;
}

EpisodeLog::EpisodeLog(int32_t env_count, ByteBudget* bytes)
    : bytes_(bytes),
      bytes_max_(kPoolBytesMin + env_count * kEnvironmentBytesMax),
      environments_(PlaceOf(env_count)),
      lengths_(PlaceOf(env_count)),
      returns_(PlaceOf(env_count)),
      unknown_levels_(env_count) {}

EpisodeLog::~EpisodeLog() { bytes_->Change(reserved_bytes_, 0); }

void EpisodeLog::Add(const StepInput& input, const Batch& batch) {
  ++number_;
  if (unknown_levels_ > 0 && input.steps) {
    LearnLevels(input, batch);
  }
  StepRun* run = nullptr;
  if (input.steps) {
    run = AddRow(input, batch);
    if (run == nullptr) {
      Lose({input.first, input.count}, EpisodeLack::kTooOld);
    }
  }
  for (size_t row = 0; row < PlaceOf(input.count); ++row) {
    if ((batch.terminated[row] | batch.truncated[row] | batch.first[row] |
         batch.prev_level_complete[row]) != 0) {
      AddTurn(input.first + static_cast<int32_t>(row), row, input, batch, run);
    }
  }
  for (size_t row = 0; row < PlaceOf(input.count); ++row) {
    const size_t place = PlaceOf(input.first) + row;
    const bool begins = batch.first[row] != 0;
    lengths_[place] = begins ? 0 : batch.episode_lengths[row];
    returns_[place] = begins ? 0 : batch.episode_returns[row];
  }
}

void EpisodeLog::LearnLevels(const StepInput& input, const Batch& batch) {
  for (size_t row = 0; row < PlaceOf(input.count); ++row) {
    Beginning& current = environments_[PlaceOf(input.first) + row].current;
    if (current.knows_level) {
      continue;
    }
    SetLevel(input.first + static_cast<int32_t>(row), batch.prev_level_seeds[row]);
  }
}

StepRun* EpisodeLog::AddRow(const StepInput& input, const Batch& batch) {
  const std::shared_ptr<StepRun> run = OpenRun({input.first, input.count});
  if (run == nullptr) {
    return nullptr;
  }
  const auto step = static_cast<int32_t>(run->numbers.size());
  run->numbers.push_back(number_);
  run->actions.insert(run->actions.end(), input.actions.begin(), input.actions.end());
  if (input.repeat > 1 || !run->counts.empty()) {
    AddCounts(input, batch, run.get());
  }
  for (size_t row = 0; row < batch.rewards.size(); ++row) {
    if (std::bit_cast<uint32_t>(batch.rewards[row]) != 0) {
      run->rewards.push_back({step, input.first + static_cast<int32_t>(row), batch.rewards[row]});
    }
  }
  const int64_t bytes = BytesOf(*run);
  if (bytes > run->reserved_bytes) {
    if (!Reserve(bytes - run->reserved_bytes)) {
      return nullptr;
    }
    run->reserved_bytes = bytes;
  }
  return run.get();
}

void EpisodeLog::AddCounts(const StepInput& input, const Batch& batch, StepRun* run) {
  run->counts.resize(run->actions.size() - PlaceOf(input.count), 1);
  for (size_t row = 0; row < PlaceOf(input.count); ++row) {
    const bool ended = (batch.terminated[row] | batch.truncated[row]) != 0;
    const bool is_stepped = ended || batch.first[row] == 0;
    const int32_t before = lengths_[PlaceOf(input.first) + row];
    const int32_t count = before < 0 ? input.repeat : batch.episode_lengths[row] - before;
    run->counts.push_back(is_stepped ? static_cast<uint16_t>(std::clamp(count, 0, input.repeat))
                                     : 0);
  }
}

std::shared_ptr<StepRun> EpisodeLog::OpenRun(Part slice) {
  const auto found = std::find_if(open_runs_.begin(), open_runs_.end(), [slice](const auto& run) {
    return run->slice.first == slice.first && run->slice.count == slice.count;
  });
  if (found != open_runs_.end()) {
    if (static_cast<int64_t>((*found)->numbers.size()) < RowsMaxOf(slice)) {
      return *found;
    }
    open_runs_.erase(found);
  } else if (open_runs_.size() >= kOpenRunsMax) {
    open_runs_.erase(open_runs_.begin());
  }
  ForgetUnneeded();
  auto run = std::make_shared<StepRun>();
  run->slice = slice;
  run->actions.reserve(static_cast<size_t>(RowsMaxOf(slice) * slice.count));
  const int64_t bytes = BytesOf(*run);
  if (!Reserve(bytes)) {
    return nullptr;
  }
  run->reserved_bytes = bytes;
  runs_.push_back(run);
  open_runs_.push_back(run);
  return run;
}

void EpisodeLog::AddTurn(int32_t environment, size_t row, const StepInput& input,
                         const Batch& batch, StepRun* run) {
  OfEnvironment& of = Of(environment);
  const size_t place = PlaceOf(environment);
  const bool ended = (batch.terminated[row] | batch.truncated[row]) != 0;
  const bool begins = batch.first[row] != 0;
  if (!input.steps &&
      std::none_of(input.resets.begin(), input.resets.end(), [environment](const Reset& reset) {
        return reset.environment == environment;
      })) {
    return;  // as it was told before
  }
  if (ended) {
    of.last = Ended{.beginning = of.current,
                    .last_number = number_,
                    .outcome = batch.terminated[row] != 0 ? EpisodeOutcome::kTerminated
                                                          : EpisodeOutcome::kTruncated,
                    .level_complete = batch.prev_level_complete[row] != 0,
                    .fingerprint = batch.fingerprints[row],
                    .total_reward = batch.episode_returns[row]};
    of.is_under_way = false;
    of.current.follows_another = !of.last->level_complete;
  } else if (begins && of.is_under_way && lengths_[place] != 0) {
    of.last = Ended{.beginning = of.current,
                    .last_number = number_ - 1,
                    .outcome = EpisodeOutcome::kReset,
                    .level_complete = false,
                    .fingerprint = 0,
                    .total_reward = returns_[place]};
    of.current.follows_another = true;
  }
  if (begins) {
    Begin(environment, batch.level_seeds[row]);
  } else if (!ended && run != nullptr) {
    run->later_levels.push_back(
        {static_cast<int32_t>(run->numbers.size()) - 1, environment, batch.level_seeds[row]});
  }
}

void EpisodeLog::Begin(int32_t environment, int32_t level_seed) {
  OfEnvironment& of = Of(environment);
  SetLevel(environment, level_seed);
  of.current.number = number_;
  of.current.lack = EpisodeLack::kNothing;
  of.is_under_way = true;
}

void EpisodeLog::SetLevel(int32_t environment, int32_t level_seed) {
  Beginning& current = Of(environment).current;
  unknown_levels_ -= current.knows_level ? 0 : 1;
  current.knows_level = true;
  current.level_seed = level_seed;
}

void EpisodeLog::Add(absl::Span<const PutIn> states) {
  ++number_;
  for (const PutIn& state : states) {
    OfEnvironment& of = Of(state.environment);
    Begin(state.environment, state.level_seed);
    of.current.follows_another = state.follows_another;
    of.current.options = state.options;
    of.current.lack = state.episode_length == 0 ? EpisodeLack::kNothing : EpisodeLack::kStatePutIn;
    of.is_under_way = !state.awaits_episode;
    lengths_[PlaceOf(state.environment)] = state.episode_length;
    returns_[PlaceOf(state.environment)] = 0;
  }
}

void EpisodeLog::Add(absl::Span<const StateToClone> pairs) {
  std::vector<OfEnvironment> sources;
  std::vector<int32_t> lengths;
  for (const StateToClone& pair : pairs) {
    sources.push_back(Of(pair.source_environment));
    lengths.push_back(lengths_[PlaceOf(pair.source_environment)]);
  }
  ++number_;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const int32_t target = pairs[i].target_environment;
    OfEnvironment& of = Of(target);
    unknown_levels_ += (sources[i].current.knows_level ? 0 : 1) - (of.current.knows_level ? 0 : 1);
    of.current = sources[i].current;
    of.current.number = number_;
    if (lengths[i] != 0) {
      of.current.lack = EpisodeLack::kStatePutIn;
    }
    of.is_under_way = sources[i].is_under_way;
    lengths_[PlaceOf(target)] = lengths[i];
    returns_[PlaceOf(target)] = 0;
  }
}

void EpisodeLog::Lose(Part part, EpisodeLack why) {
  for (int32_t environment = part.first; environment < part.first + part.count; ++environment) {
    Beginning& current = Of(environment).current;
    current.number = number_;
    if (current.lack == EpisodeLack::kNothing) {
      current.lack = why;
    }
    if (why == EpisodeLack::kBeforeProcess) {
      lengths_[PlaceOf(environment)] = -1;
    }
  }
}

absl::StatusOr<EpisodeLog::Pieces> EpisodeLog::Read(int32_t environment, bool under_way) {
  const OfEnvironment& of = Of(environment);
  if (under_way ? !of.is_under_way : !of.last.has_value()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "environment ", environment,
        under_way ? " is between two episodes: the last one has ended, and the next has not begun"
                  : " has ended no episode yet"));
  }
  const Beginning& beginning = under_way ? of.current : of.last->beginning;
  Pieces pieces;
  pieces.environment_ = environment;
  pieces.begin_ = beginning.number;
  pieces.end_ = under_way ? number_ : of.last->last_number;
  pieces.episode_.level_seed = beginning.level_seed;
  pieces.episode_.options = beginning.options;
  pieces.episode_.lack = beginning.lack;
  pieces.episode_.follows_another = beginning.follows_another;
  if (under_way) {
    pieces.episode_.total_reward = returns_[PlaceOf(environment)];
  } else {
    pieces.episode_.outcome = of.last->outcome;
    pieces.episode_.level_complete = of.last->level_complete;
    pieces.episode_.fingerprint = of.last->fingerprint;
    pieces.episode_.total_reward = of.last->total_reward;
  }
  for (const std::shared_ptr<StepRun>& run : runs_) {
    if (run->Holds(environment) && run->numbers.back() > pieces.begin_ &&
        run->numbers.front() <= pieces.end_) {
      pieces.runs_.push_back(run);
      // What follows goes into another, so that nobody changes this one while it is read.
      std::erase(open_runs_, run);
    }
  }
  return pieces;
}

bool EpisodeLog::Reserve(int64_t bytes) {
  while (reserved_bytes_ + bytes > bytes_max_ || !bytes_->Change(0, bytes)) {
    if (runs_.size() <= 1) {
      return false;  // the newest is being written
    }
    ForgetOldest();
  }
  reserved_bytes_ += bytes;
  return true;
}

bool EpisodeLog::IsNeeded(const StepRun& run) const {
  const auto needs = [&run](const OfEnvironment& of) {
    return of.current.number < run.numbers.back() ||
           (of.last.has_value() && of.last->beginning.number < run.numbers.back() &&
            of.last->last_number >= run.numbers.front());
  };
  const auto first = environments_.begin() + run.slice.first;
  return std::any_of(first, first + run.slice.count, needs);
}

void EpisodeLog::ForgetUnneeded() {
  while (!runs_.empty() && !IsNeeded(*runs_.front())) {
    ForgetOldest();
  }
}

void EpisodeLog::ForgetOldest() {
  const std::shared_ptr<StepRun> run = runs_.front();
  runs_.pop_front();
  std::erase(open_runs_, run);
  bytes_->Change(run->reserved_bytes, 0);
  reserved_bytes_ -= run->reserved_bytes;
  const auto lose = [&run](Beginning* beginning) {
    if (beginning->number < run->numbers.back() && beginning->lack == EpisodeLack::kNothing) {
      beginning->lack = EpisodeLack::kTooOld;
    }
  };
  for (int32_t i = run->slice.first; i < run->slice.first + run->slice.count; ++i) {
    lose(&Of(i).current);
    if (Of(i).last.has_value() && Of(i).last->last_number >= run->numbers.front()) {
      lose(&Of(i).last->beginning);
    }
  }
}

}  // namespace procgen
