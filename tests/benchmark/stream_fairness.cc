// fair/...: several learners at once, each with a pool, a connection and a thread of its own.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/barrier.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/remote_learner.h"
#include "tests/benchmark/stream_courses.h"
#include "tests/benchmark/time_now.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 16;
// Long enough for each of many learners to get many turns.
constexpr absl::Duration kRound = absl::Milliseconds(500);

struct Course {
  std::unique_ptr<RemoteLearner> learner;
  int64_t step_count = 0;
  absl::Status status;
};

// All step at once until the time is over. Returns the time that it took.
absl::Duration StepAtOnce(absl::Span<Course> courses) {
  std::atomic<bool> is_over = false;
  std::vector<std::thread> threads;
  const int party_count = static_cast<int>(courses.size()) + 1;
  auto* const start = new absl::Barrier(party_count);  // the last one frees it
  for (Course& course : courses) {
    threads.emplace_back([&course, &is_over, start] {
      if (start->Block()) {
        delete start;
      }
      while (!is_over && course.status.ok()) {
        course.status = course.learner->Step();
        ++course.step_count;
      }
    });
  }
  if (start->Block()) {
    delete start;
  }
  const absl::Duration begin = TimeNow(TimeKind::kWall);
  absl::SleepFor(kRound);
  is_over = true;
  const absl::Duration time = TimeNow(TimeKind::kWall) - begin;
  for (std::thread& thread : threads) {
    thread.join();
  }
  return time;
}

absl::Status StatusOf(absl::Span<const Course> courses) {
  absl::Status status;
  for (const Course& course : courses) {
    status.Update(course.status);
  }
  return status;
}

void Report(absl::Span<const Course> courses, absl::Duration time, double alone_per_second,
            benchmark::State& state) {
  const auto fewer = [](const Course& one, const Course& other) {
    return one.step_count < other.step_count;
  };
  const auto [least, most] = std::minmax_element(courses.begin(), courses.end(), fewer);
  const int64_t all =
      std::accumulate(courses.begin(), courses.end(), int64_t{0},
                      [](int64_t sum, const Course& course) { return sum + course.step_count; });
  const double equal_share = static_cast<double>(all) / static_cast<double>(courses.size());
  const double per_second = static_cast<double>(all * kEnvCount) / absl::ToDoubleSeconds(time);
  state.counters["least_share"] = static_cast<double>(least->step_count) / equal_share;
  state.counters["most_share"] = static_cast<double>(most->step_count) / equal_share;
  state.counters["items_per_second"] = per_second;
  state.counters["alone_ratio"] = per_second / alone_per_second;
}

void RunFairness(int learner_count, benchmark::State& state) {
  const auto server = StartStreamServer();
  absl::Status status = server.status();
  std::vector<Course> courses(static_cast<size_t>(learner_count));
  std::vector<Course> alone(1);  // one learner while the others rest
  const auto start = [&](Course* course) {
    if (status.ok()) {
      auto learner = RemoteLearner::Start((*server)->address(), {.env_count = kEnvCount});
      status = learner.status();
      if (status.ok()) {
        course->learner = *std::move(learner);
      }
    }
  };
  std::for_each(courses.begin(), courses.end(), [&](Course& course) { start(&course); });
  start(&alone.front());
  absl::Duration time;
  absl::Duration alone_time;
  const auto round = [&] {
    time += StepAtOnce(absl::MakeSpan(courses));
    alone_time += StepAtOnce(absl::MakeSpan(alone));
    absl::Status stepped = StatusOf(courses);
    stepped.Update(StatusOf(alone));
    return stepped;
  };
  if (RunRounds(status, round, state)) {
    Report(courses, time,
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
