#include "server/rpc/node_reporter.h"

#include <atomic>
#include <memory>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(NodeReporterTest, ReportsAtOnceAndOnRequest) {
  const std::unique_ptr<Cluster> cluster = Cluster::Alone("a");
  std::atomic<bool> draining = false;
  NodeReporter reporter(cluster.get(), [&] {
    NodeReporter::Snapshot snapshot;
    snapshot.status.draining = draining;
    return snapshot;
  });
  ASSERT_EQ(cluster->Nodes().size(), 1U);
  EXPECT_EQ(cluster->Nodes()[0].node_id, "a");
  EXPECT_FALSE(cluster->Nodes()[0].draining);
  draining = true;
  reporter.ReportNow();
  EXPECT_TRUE(cluster->Nodes()[0].draining);
}

TEST(NodeReporterTest, MeasuresTheRateOfSteps) {
  const std::unique_ptr<Cluster> cluster = Cluster::Alone("a");
  std::atomic<int64_t> step_count = 0;
  const NodeReporter reporter(cluster.get(), [&] {
    NodeReporter::Snapshot snapshot;
    snapshot.step_count = step_count;
    return snapshot;
  });
  step_count = 1000;
  while (cluster->Nodes()[0].steps_per_second == 0) {
    absl::SleepFor(absl::Milliseconds(5));
  }
  // Over one second, or longer on a slow machine.
  EXPECT_LE(cluster->Nodes()[0].steps_per_second, 1001);
}

}  // namespace
}  // namespace procgen
