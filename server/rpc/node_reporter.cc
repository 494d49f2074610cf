#include "server/rpc/node_reporter.h"

#include <algorithm>
#include <utility>

namespace procgen {
namespace {

// Must be at most half of kPublishTimeout.
constexpr absl::Duration kInterval = absl::Seconds(1);

}  // namespace

NodeReporter::NodeReporter(Cluster* cluster, std::function<Snapshot()> take_snapshot)
    : cluster_(cluster),
      take_snapshot_(std::move(take_snapshot)),
      measured_at_(SteadyNow()),
      timer_(SteadyNow, [this](absl::Time now) {
        Report(true);
        return now + kInterval;
      }) {
  ReportNow();
  timer_.ArmBy(SteadyNow() + kInterval);
}

void NodeReporter::ReportNow() { Report(false); }

void NodeReporter::Report(bool measures) {
  absl::MutexLock lock(&mutex_);
  Snapshot snapshot = take_snapshot_();
  if (measures) {
    const absl::Time now = SteadyNow();
    const double seconds = absl::ToDoubleSeconds(now - measured_at_);
    const auto steps = static_cast<double>(snapshot.step_count - measured_steps_);
    steps_per_second_ = seconds > 0 ? std::max(0.0, steps) / seconds : 0;
    measured_at_ = now;
    measured_steps_ = snapshot.step_count;
  }
  snapshot.status.steps_per_second = steps_per_second_;
  cluster_->Publish(std::move(snapshot.status));
}

}  // namespace procgen
