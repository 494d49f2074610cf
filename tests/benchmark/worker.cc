// procgen-benchmark-worker: a C++ learner that alternates with the learners of python_benchmark.py.
// README.md in this folder describes the benchmark.
#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "tests/benchmark/learners/local_learner.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/cost.h"
#include "tests/benchmark/stream/stream_cases.h"

ABSL_FLAG(int32_t, workers, procgen::kStreamWorkerCount, "threads of a pool in this process");

namespace procgen {
namespace {

// Runs one turn per line of standard input and prints its microseconds per step.
absl::Status TakeTurns(absl::FunctionRef<absl::Status(Cost*)> turn) {
  std::cout << "ready" << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    Cost cost;
    absl::Status status = turn(&cost);
    if (!status.ok()) {
      return status;
    }
    std::cout << absl::ToDoubleMicroseconds(cost.wall) << std::endl;
  }
  return absl::OkStatus();
}

absl::Status CompeteInProcess(const std::string& game, int32_t env_count) {
  // All arrays and two batches in turn, as a learner uses them.
  auto learner = LocalLearner::Start({.game = game,
                                      .worker_count = absl::GetFlag(FLAGS_workers),
                                      .batch_count = kRequestsInFlight,
                                      .answers_all = true},
                                     env_count);
  if (!learner.ok()) {
    return learner.status();
  }
  return TakeTurns([&](Cost* cost) {
    return cost->MeasureRound(kContestantTime, [&] { return learner->Step(); });
  });
}

absl::Status CompeteOverStream(const std::string& address, const RemoteCase& remote_case) {
  auto learner = RemoteLearner::Start(address, remote_case);
  if (!learner.ok()) {
    return learner.status();
  }
  return TakeTurns([&](Cost* cost) { return MeasureAhead(learner->get(), cost); });
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "[--workers=N] GAME ENVIRONMENTS [SERVER [compressed]]\n"
      "Steps a pool in easy mode, in this process or on a server, for a while for each line of "
      "standard input;\nprints the duration of a step, in microseconds.");
  const std::vector<char*> arguments = absl::ParseCommandLine(argc, argv);
  const size_t count = arguments.size();
  int32_t env_count = 0;
  const absl::string_view how = count == 5 ? arguments[4] : "";
  const bool is_compressed = how == "compressed";
  if (count < 3 || count > 5 || (count == 5 && !is_compressed) ||
      !absl::SimpleAtoi(arguments[2], &env_count) || env_count < 1 ||
      absl::GetFlag(FLAGS_workers) < 1) {
    std::cerr << "procgen-benchmark-worker: invalid arguments; --help describes them\n";
    return 2;
  }
  const absl::Status status =
      count == 3 ? procgen::CompeteInProcess(arguments[1], env_count)
                 : procgen::CompeteOverStream(arguments[3],
                                              {.game = arguments[1],
                                               .env_count = env_count,
                                               .requests_in_flight = procgen::kRequestsInFlight,
                                               .is_compressed = is_compressed});
  if (!status.ok()) {
    std::cerr << "procgen-benchmark-worker: " << status << "\n";
    return 1;
  }
  return 0;
}
