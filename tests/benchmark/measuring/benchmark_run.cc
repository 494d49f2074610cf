#include "tests/benchmark/measuring/benchmark_run.h"

#include <iostream>
#include <string>
#include <vector>

#include "absl/flags/parse.h"
#include "absl/strings/str_cat.h"
#include "benchmark/benchmark.h"

namespace procgen {

int RunBenchmarks(int argc, char** argv, double min_time_seconds, void (*register_all)()) {
  // The default comes first, so that a flag on the command line overrides it.
  std::string min_time = absl::StrCat("--benchmark_min_time=", min_time_seconds);
  std::vector<char*> arguments(argv, argv + argc);
  arguments.insert(arguments.begin() + 1, min_time.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  // Google Benchmark has removed its own flags.
  if (const std::vector<char*> rest = absl::ParseCommandLine(count, arguments.data());
      rest.size() > 1) {
    std::cerr << "unexpected argument '" << rest[1] << "'\n";
    return 1;
  }
  register_all();
  const bool ran = benchmark::RunSpecifiedBenchmarks() > 0;
  benchmark::Shutdown();
  return ran ? 0 : 1;
}

}  // namespace procgen
