#ifndef TESTS_BENCHMARK_BENCHMARK_RUN_H_
#define TESTS_BENCHMARK_BENCHMARK_RUN_H_

namespace procgen {

// What main() of a benchmark program does: reads Google Benchmark's flags, lets `register_all` add
// the benchmarks and runs those that the flags select, each for `min_time_seconds` of the calling
// thread's time unless --benchmark_min_time says otherwise. Returns the exit status: 1 for an
// unknown flag or if nothing was selected.
int RunBenchmarks(int argc, char** argv, double min_time_seconds, void (*register_all)());

}  // namespace procgen

#endif  // TESTS_BENCHMARK_BENCHMARK_RUN_H_
