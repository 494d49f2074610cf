// procgen-conformance FILE...: replays recordings and compares every result.

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/strings/str_cat.h"
#include "envcore/pool/shared_art.h"
#include "envcore/trace/trace.h"
#include "procgen_client/local_pool.h"
#include "procgen_client/servers.h"
#include "tools/conformance/replay.h"

ABSL_FLAG(std::string, server, "",
          "replay through the server at this address, e.g. 127.0.0.1:50051, or through several, "
          "separated "
          "by commas; empty: in this process");
ABSL_FLAG(std::string, art_dir, "",
          "folder with the art of Procgen 0.10.7: draws with it and also compares the observations "
          "that were recorded with it; with --server: the server draws with that art");
ABSL_FLAG(int32_t, workers, 1,
          "threads that step the environments in this process, at least 1; unused with --server");

namespace procgen {
namespace {

constexpr char kUsage[] =
    "usage: procgen-conformance [--server ADDRESS] [--workers N] [--art_dir DIR] FILE...";

enum class Verdict { kPassed, kFailed, kSkipped };

// How recordings are replayed.
struct ReplayTarget {
  std::string server;                    // address; empty: in this process
  std::shared_ptr<const SharedArt> art;  // art to draw with in this process; null: the built-in art
  bool has_upstream_art = false;         // whether the observations are drawn with upstream's art
};

absl::StatusOr<ReplayTarget> MakeReplayTarget() {
  ReplayTarget target;
  target.server = absl::GetFlag(FLAGS_server);
  const std::string folder = absl::GetFlag(FLAGS_art_dir);
  target.has_upstream_art = !folder.empty();
  if (target.has_upstream_art && target.server.empty()) {
    auto art = SharedArt::LoadFolder(folder);
    if (!art.ok()) {
      return art.status();
    }
    target.art = *std::move(art);
  }
  return target;
}

absl::StatusOr<std::unique_ptr<procgen_client::Pool>> MakePool(const ReplayTarget& target,
                                                               const Trace& trace) {
  PoolOptions options = PoolOptionsOf(trace);
  if (target.server.empty()) {
    options.art = target.art;
    // The calling thread is a worker too.
    auto pool = procgen_client::LocalPool::Create(options, absl::GetFlag(FLAGS_workers) - 1);
    if (!pool.ok()) {
      return pool.status();
    }
    return *std::move(pool);
  }
  const auto servers = procgen_client::Servers::Connect(target.server);
  if (!servers.ok()) {
    return servers.status();
  }
  return procgen_client::CreatePool(*servers, options);
}

Verdict Replay(const ReplayTarget& target, const std::string& path) {
  const absl::StatusOr<Trace> trace = ReadTrace(path);
  if (!trace.ok()) {
    std::cout << path << ": " << trace.status() << "\n";
    return Verdict::kFailed;
  }
  const bool with_pictures = trace->HasComparablePictures(target.has_upstream_art);
  const auto pool = MakePool(target, *trace);
  if (absl::IsUnimplemented(pool.status())) {
    std::cout << path << ": skipped: " << pool.status().message() << "\n";
    return Verdict::kSkipped;
  }
  if (!pool.ok()) {
    std::cout << path << ": " << pool.status() << "\n";
    return Verdict::kFailed;
  }
  const std::string difference = FirstDifference(*trace, **pool, with_pictures);
  std::cout << path << ": " << (difference.empty() ? "ok" : difference) << std::endl;
  return difference.empty() ? Verdict::kPassed : Verdict::kFailed;
}

int Main(const std::vector<char*>& arguments) {
  if (arguments.size() < 2 || absl::GetFlag(FLAGS_workers) < 1) {
    std::cerr << kUsage << "\nat least one FILE is required, and N must be at least 1\n";
    return 2;
  }
  const absl::StatusOr<ReplayTarget> target = MakeReplayTarget();
  if (!target.ok()) {
    std::cerr << "procgen-conformance: --art_dir: " << target.status().message() << "\n";
    return 2;
  }
  int passed = 0;
  int failed = 0;
  int skipped = 0;
  for (size_t i = 1; i < arguments.size(); ++i) {
    switch (Replay(*target, arguments[i])) {
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
  absl::SetProgramUsageMessage(absl::StrCat(
      "Replays recordings of Procgen 0.10.7 and compares every result.\n", procgen::kUsage));
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
