// watch/...: a learner with a subscriber that watches its pool, compared with the same learner
// without.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/time_now.h"
#include "tests/benchmark/stream/stream_cases.h"
#include "tests/benchmark/stream/viewer_process.h"

namespace procgen {
namespace {

// The speed of machines varies, so rounds are short and many, and the benchmark reports the median.
struct Rounds {
  int32_t size_px = 0;
  absl::Duration share;  // duration of each half of a round
  int count = 0;
};
constexpr Rounds kAgentRounds = {kObservationSizePx, absl::Milliseconds(200), 200};
// A busy machine delivers the human view about once a second.
constexpr Rounds kHumanRounds = {256, absl::Milliseconds(1500), 25};

// Returns the steps per second during `share`.
absl::StatusOr<double> RateOf(RemoteLearner* learner, absl::Duration share) {
  int64_t step_count = 0;
  const absl::Duration begin = TimeNow(TimeKind::kWall);
  absl::Duration time;
  while ((time = TimeNow(TimeKind::kWall) - begin) < share) {
    if (absl::Status status = learner->Step(); !status.ok()) {
      return status;
    }
    ++step_count;
  }
  return static_cast<double>(step_count) / absl::ToDoubleSeconds(time);
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class WatchContest {
 public:
  static absl::StatusOr<std::unique_ptr<WatchContest>> Start(int32_t env_count,
                                                             const Rounds& rounds) {
    auto contest = std::make_unique<WatchContest>();
    contest->share_ = rounds.share;
    absl::Status status = contest->Begin(env_count, rounds.size_px);
    if (!status.ok()) {
      return status;
    }
    return contest;
  }

  // Measures with and without the subscriber, in alternating order.
  absl::Status RunRound() {
    const bool watched_first = ratios_.size() % 2 == 0;
    absl::StatusOr<double> first = Measure(watched_first);
    absl::StatusOr<double> second = first.ok() ? Measure(!watched_first) : first;
    if (!second.ok()) {
      return second.status();
    }
    rates_.push_back(watched_first ? *first : *second);
    ratios_.push_back(watched_first ? *first / *second : *second / *first);
    return absl::OkStatus();
  }

  void Report(int32_t env_count, benchmark::State& state) const {
    state.counters["watched_ratio"] = MedianOf(ratios_);
    state.counters["watched_ratio_least"] = *std::min_element(ratios_.begin(), ratios_.end());
    state.counters["frame_sets_per_second"] =
        static_cast<double>(frame_set_count_) /
        (absl::ToDoubleSeconds(share_) * static_cast<double>(ratios_.size()));
    state.counters["items_per_second"] = MedianOf(rates_) * env_count;
  }

 private:
  absl::Status Begin(int32_t env_count, int32_t size_px) {
    auto server = StartStreamServer();
    if (!server.ok()) {
      return server.status();
    }
    server_ = *std::move(server);
    auto learner = RemoteLearner::Start(server_->address(), {.env_count = env_count});
    if (!learner.ok()) {
      return learner.status();
    }
    learner_ = *std::move(learner);
    viewer_ = std::make_unique<ViewerProcess>(server_->address(), size_px);
    return absl::OkStatus();
  }

  absl::StatusOr<double> Measure(bool watched) {
    if (!watched) {
      return RateOf(learner_.get(), share_);
    }
    const auto begun = viewer_->Toggle();
    absl::StatusOr<double> rate = begun.ok() ? RateOf(learner_.get(), share_) : begun.status();
    const auto frame_set_count = rate.ok() ? viewer_->Toggle() : begun;
    if (!frame_set_count.ok()) {
      return frame_set_count.status();
    }
    frame_set_count_ += *frame_set_count;
    return rate;
  }

  absl::Duration share_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<RemoteLearner> learner_;
  std::unique_ptr<ViewerProcess> viewer_;
  std::vector<double> ratios_;
  std::vector<double> rates_;  // with the subscriber
  int64_t frame_set_count_ = 0;
};

void RunWatch(int32_t env_count, const Rounds& rounds, benchmark::State& state) {
  const auto contest = WatchContest::Start(env_count, rounds);
  if (RunRounds(
          contest.status(), [&] { return (*contest)->RunRound(); }, state)) {
    (*contest)->Report(env_count, state);
  }
}

}  // namespace

void RegisterWatches() {
  for (const Rounds& rounds : {kAgentRounds, kHumanRounds}) {
    for (const int32_t env_count : {64, 256}) {
      benchmark::RegisterBenchmark(
          absl::StrCat("watch/size_px:", rounds.size_px, "/environments:", env_count).c_str(),
          [env_count, rounds](benchmark::State& state) { RunWatch(env_count, rounds, state); })
          ->Iterations(rounds.count)
          ->UseManualTime();
    }
  }
}

}  // namespace procgen
