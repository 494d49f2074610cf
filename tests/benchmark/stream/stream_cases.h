#ifndef TESTS_BENCHMARK_STREAM_STREAM_CASES_H_
#define TESTS_BENCHMARK_STREAM_STREAM_CASES_H_

#include <cstdint>
#include <initializer_list>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/measuring/cost.h"

namespace procgen {

// The benchmarks of procgen-benchmark-stream, one file each.
void RegisterTcpStreams();  // stream/tcp/...
void RegisterLatencies();   // latency/...
void RegisterFairness();    // fair/...

// Duration of one turn of a contestant.
inline constexpr absl::Duration kContestantTime = absl::Milliseconds(50);

// Requests in flight of a learner of stream/...: as a learner that works while the pool is stepped.
inline constexpr int kRequestsInFlight = 2;

// Measures one turn of a contestant that sends requests ahead.
template <typename Sender>
absl::Status MeasureAhead(Sender* sender, Cost* cost) {
  absl::Status status = sender->SendAhead();
  if (status.ok()) {
    status = cost->MeasureRound(kContestantTime, [&] { return sender->Exchange(); });
  }
  return status.ok() ? sender->ReceiveRest() : status;
}

// Runs `round`, which measures all contestants in turn, once per iteration of `state`. `status` is
// the result of the setup. Returns whether all succeeded; otherwise reports the error to `state`.
bool RunRounds(absl::Status status, absl::FunctionRef<absl::Status()> round,
               benchmark::State& state);

// Registers `name`/environments:N for each size N. Contest::Start(N) creates the contest, RunRound
// is repeated, and Report(N, state) writes the counters.
template <typename Contest>
void RegisterContests(absl::string_view name, std::initializer_list<int32_t> sizes) {
  for (const int32_t env_count : sizes) {
    benchmark::RegisterBenchmark(absl::StrCat(name, "/environments:", env_count).c_str(),
                                 [env_count](benchmark::State& state) {
                                   const auto contest = Contest::Start(env_count);
                                   const auto round = [&] { return (*contest)->RunRound(); };
                                   if (RunRounds(contest.status(), round, state)) {
                                     (*contest)->Report(env_count, state);
                                   }
                                 })
        ->UseManualTime();
  }
}

}  // namespace procgen

#endif  // TESTS_BENCHMARK_STREAM_STREAM_CASES_H_
