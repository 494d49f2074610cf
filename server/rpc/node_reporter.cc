#include "server/rpc/node_reporter.h"

#include <algorithm>
#include <utility>

namespace procgen {
namespace {

// A few of these fit into kStatusLifespan.
constexpr absl::Duration kInterval = absl::Seconds(1);

}  // namespace

NodeReporter::NodeReporter(Cluster* cluster, std::function<Standing()> standing)
    : cluster_(cluster), standing_(std::move(standing)), measured_at_(SteadyNow()) {
  ReportNow();
  thread_ = std::thread([this] { ReportUntilStopped(); });
}

NodeReporter::~NodeReporter() {
  stopped_.Notify();
  thread_.join();
}

void NodeReporter::ReportNow() { Report(false); }

void NodeReporter::ReportUntilStopped() {
  while (!stopped_.WaitWithTimeout(kInterval)) {
    Report(true);
  }
}

void NodeReporter::Report(bool measures) {
  absl::MutexLock lock(&mutex_);
  Standing standing = standing_();
  if (measures) {
    const absl::Time now = SteadyNow();
    const double seconds = absl::ToDoubleSeconds(now - measured_at_);
    const auto steps = static_cast<double>(standing.step_count - measured_steps_);
    steps_per_second_ = seconds > 0 ? std::max(0.0, steps) / seconds : 0;
    measured_at_ = now;
    measured_steps_ = standing.step_count;
  }
  standing.status.steps_per_second = steps_per_second_;
  cluster_->Publish(std::move(standing.status));
}

}  // namespace procgen
