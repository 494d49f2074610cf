#ifndef TESTS_BENCHMARK_MEASURING_BENCHMARK_RUN_H_
#define TESTS_BENCHMARK_MEASURING_BENCHMARK_RUN_H_

namespace procgen {

// The body of main() of a benchmark program. Parses Google Benchmark's flags and those of
// the program (absl::GetFlag), calls `register_all`
// to add the benchmarks and runs those that the flags select. `min_time_seconds` is the default of
// --benchmark_min_time. Returns the exit status: 1 for an unknown flag or an empty selection.
int RunBenchmarks(int argc, char** argv, double min_time_seconds, void (*register_all)());

}  // namespace procgen

#endif  // TESTS_BENCHMARK_MEASURING_BENCHMARK_RUN_H_
