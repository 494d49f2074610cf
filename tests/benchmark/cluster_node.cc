// One node of a cluster without the rest of a server, for cluster_traffic.py. Prints a line
// "SECONDS COUNT" (monotonic clock, listed nodes) at each change of the count. Leaves at end of
// standard input.
//
//   procgen-benchmark-cluster-node NODE_ID ADDRESS [PEER]...

#include <cstdint>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/cluster/cluster.h"
#include "server/concurrency/steady_time.h"

namespace procgen {
namespace {

double MonotonicSeconds() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) / 1e9;
}

int Run(const ClusterOptions& options) {
  absl::StatusOr<std::unique_ptr<Cluster>> joined = Cluster::Join(options);
  if (!joined.ok()) {
    std::fprintf(stderr, "%s\n", joined.status().ToString().c_str());
    return 1;
  }
  Cluster& cluster = **joined;
  size_t reported = 0;
  SteadyNotification stopped;
  std::thread observer([&] {
    do {
      const size_t count = cluster.Nodes().size();
      if (std::exchange(reported, count) != count) {
        std::printf("%.6f %zu\n", MonotonicSeconds(), count);
        std::fflush(stdout);
      }
    } while (!stopped.WaitWithTimeout(absl::Milliseconds(50)));
  });
  std::thread publisher([&] {
    NodeStatus status;
    status.address = options.address;
    status.server_version = "1.2.3";
    status.environment_capacity = 4096;
    status.worker_count = 4;
    status.healthy = true;
    do {
      cluster.Publish(status);
    } while (!stopped.WaitWithTimeout(absl::Seconds(1)));
  });
  while (std::getchar() != EOF) {
  }
  stopped.Notify();
  publisher.join();
  observer.join();
  return 0;
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s NODE_ID ADDRESS [PEER]...\n", argv[0]);
    return 2;
  }
  procgen::ClusterOptions options;
  options.name = "traffic";
  options.node_id = argv[1];
  options.address = argv[2];
  options.peers.assign(argv + 3, argv + argc);
  return procgen::Run(options);
}
