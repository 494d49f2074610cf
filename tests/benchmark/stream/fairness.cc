// fair/...: several learners at once, each with its own pool, connection and thread.
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <latch>
#include <memory>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/time_now.h"
#include "tests/benchmark/stream/stream_cases.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 16;
// Long enough for many steps of each of many learners.
constexpr absl::Duration kRound = absl::Milliseconds(500);

struct Rival {
  std::unique_ptr<RemoteLearner> learner;
  int64_t step_count = 0;
  absl::Status status;
};

// Steps all learners concurrently for kRound. Returns the elapsed time.
absl::Duration StepAtOnce(absl::Span<Rival> rivals) {
  std::atomic<bool> is_over = false;
  std::vector<std::thread> threads;
  std::latch start(static_cast<std::ptrdiff_t>(rivals.size()) + 1);
  for (Rival& rival : rivals) {
    threads.emplace_back([&rival, &is_over, &start] {
      start.arrive_and_wait();
      while (!is_over && rival.status.ok()) {
        rival.status = rival.learner->Step();
        ++rival.step_count;
      }
    });
  }
  start.arrive_and_wait();
  const absl::Duration begin = TimeNow(TimeKind::kWall);
  absl::SleepFor(kRound);
  is_over = true;
  const absl::Duration time = TimeNow(TimeKind::kWall) - begin;
  for (std::thread& thread : threads) {
    thread.join();
  }
  return time;
}

absl::Status StatusOf(absl::Span<const Rival> rivals) {
  absl::Status status;
  for (const Rival& rival : rivals) {
    status.Update(rival.status);
  }
  return status;
}

void Report(absl::Span<const Rival> rivals, absl::Duration time, double alone_per_second,
            benchmark::State& state) {
  const auto fewer = [](const Rival& one, const Rival& other) {
    return one.step_count < other.step_count;
  };
  const auto [least, most] = std::minmax_element(rivals.begin(), rivals.end(), fewer);
  const int64_t all =
      std::accumulate(rivals.begin(), rivals.end(), int64_t{0},
                      [](int64_t sum, const Rival& rival) { return sum + rival.step_count; });
  const double equal_share = static_cast<double>(all) / static_cast<double>(rivals.size());
  const double per_second = static_cast<double>(all * kEnvCount) / absl::ToDoubleSeconds(time);
  state.counters["least_share"] = static_cast<double>(least->step_count) / equal_share;
  state.counters["most_share"] = static_cast<double>(most->step_count) / equal_share;
  state.counters["items_per_second"] = per_second;
  state.counters["alone_ratio"] = per_second / alone_per_second;
}

void RunFairness(int learner_count, benchmark::State& state) {
  const auto server = StartStreamServer();
  absl::Status status = server.status();
  std::vector<Rival> rivals(static_cast<size_t>(learner_count));
  std::vector<Rival> alone(1);  // runs while the others are idle
  const auto start = [&](Rival* rival) {
    if (status.ok()) {
      auto learner = RemoteLearner::Start((*server)->address(), {.env_count = kEnvCount});
      status = learner.status();
      if (status.ok()) {
        rival->learner = *std::move(learner);
      }
    }
  };
  std::for_each(rivals.begin(), rivals.end(), [&](Rival& rival) { start(&rival); });
  start(&alone.front());
  absl::Duration time;
  absl::Duration alone_time;
  const auto round = [&] {
    time += StepAtOnce(absl::MakeSpan(rivals));
    alone_time += StepAtOnce(absl::MakeSpan(alone));
    absl::Status stepped = StatusOf(rivals);
    stepped.Update(StatusOf(alone));
    return stepped;
  };
  if (RunRounds(status, round, state)) {
    Report(rivals, time,
           static_cast<double>(alone.front().step_count * kEnvCount) /
               absl::ToDoubleSeconds(alone_time),
           state);
  }
}

}  // namespace

void RegisterFairness() {
  for (const int learner_count : {1, 4, 16}) {
    benchmark::RegisterBenchmark(
        absl::StrCat("fair/learners:", learner_count).c_str(),
        [learner_count](benchmark::State& state) { RunFairness(learner_count, state); })
        ->UseManualTime();
  }
}

}  // namespace procgen
