// procgen-conformance FILE...: replays recordings and compares every observed value with them.

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/strings/str_cat.h"
#include "tests/conformance/player.h"
#include "tests/conformance/replay.h"
#include "tests/conformance/trace.h"

ABSL_FLAG(
    std::string, server, "",
    "replay through the server at this address, e.g. 127.0.0.1:50051; empty: in this process");
ABSL_FLAG(int32_t, workers, 1, "threads that step the environments in this process, at least 1");

namespace procgen {
namespace {

enum class Verdict { kPassed, kFailed, kSkipped };

absl::StatusOr<std::unique_ptr<Player>> MakePlayer(const Trace& trace) {
  const std::string address = absl::GetFlag(FLAGS_server);
  const bool with_pictures = trace.HasComparablePictures();
  return address.empty() ? MakeLocalPlayer(trace, absl::GetFlag(FLAGS_workers), with_pictures)
                         : MakeRemotePlayer(trace, address, with_pictures);
}

Verdict Replay(const std::string& path) {
  const absl::StatusOr<Trace> trace = ReadTrace(path);
  if (!trace.ok()) {
    std::cout << path << ": " << trace.status() << "\n";
    return Verdict::kFailed;
  }
  absl::StatusOr<std::unique_ptr<Player>> player = MakePlayer(*trace);
  if (absl::IsUnimplemented(player.status())) {
    std::cout << path << ": skipped: " << player.status().message() << "\n";
    return Verdict::kSkipped;
  }
  if (!player.ok()) {
    std::cout << path << ": " << player.status() << "\n";
    return Verdict::kFailed;
  }
  const std::string difference = FirstDifference(*trace, **player);
  std::cout << path << ": " << (difference.empty() ? "ok" : difference) << std::endl;
  return difference.empty() ? Verdict::kPassed : Verdict::kFailed;
}

int Main(const std::vector<char*>& arguments) {
  if (arguments.size() < 2 || absl::GetFlag(FLAGS_workers) < 1) {
    std::cerr << "usage: procgen-conformance [--server ADDRESS] [--workers N] FILE...\n"
                 "at least one file is needed, and N must be at least 1\n";
    return 2;
  }
  int passed = 0;
  int failed = 0;
  int skipped = 0;
  for (size_t i = 1; i < arguments.size(); ++i) {
    switch (Replay(arguments[i])) {
      case Verdict::kPassed:
        ++passed;
        break;
      case Verdict::kFailed:
        ++failed;
        break;
      case Verdict::kSkipped:
        ++skipped;
        break;
    }
  }
  std::cout << passed << " passed, " << failed << " failed, " << skipped << " skipped\n";
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "Replays recordings of the released benchmark and compares every value that is observed.\n"
      "usage: procgen-conformance [--server ADDRESS] [--workers N] FILE...");
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
