#include "server/cluster/failure_detector.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/cluster/timing.h"

namespace procgen {
namespace {

using Incarnations = std::map<std::string, int64_t>;

void AddAll(const std::vector<NodeLoss>& losses, Incarnations* incarnations) {
  for (const NodeLoss& loss : losses) {
    int64_t& incarnation = incarnations->try_emplace(loss.node_id, -1).first->second;
    incarnation = std::max(incarnation, loss.incarnation);
  }
}

// Returns the highest lost incarnation of a node; -1: it was not lost.
int64_t IncarnationIn(const Incarnations& lost, const std::string& node_id) {
  const auto node = lost.find(node_id);
  return node == lost.end() ? -1 : node->second;
}

}  // namespace

bool FailureDetector::Update(absl::Time now, const std::vector<NodeReport>& reports,
                             const std::vector<std::string>& heard, bool sends_heartbeats) {
  const int64_t incarnation_before = incarnation_;
  const std::vector<NodeLoss> losses_before = losses_;
  // A process that was stopped has not listened: the time of its pause is not silence of others.
  AddSilence(std::min(now - updated_, 2 * kRefreshInterval), heard);
  updated_ = now;

  Incarnations known;
  for (const NodeReport& report : reports) {
    known[report.status.node_id] = report.incarnation;
  }
  DropOldLosses(known, heard);
  AddLosses(known);

  // A lost node may be cut off itself, and then it loses the others: its losses do not count.
  Incarnations lost;
  for (const NodeReport& report : reports) {
    AddAll(report.losses, &lost);
  }
  const int64_t refuted = IncarnationIn(lost, node_id_);
  Incarnations counted;
  AddAll(losses_, &counted);
  for (const NodeReport& report : reports) {
    if (report.incarnation > IncarnationIn(lost, report.status.node_id)) {
      AddAll(report.losses, &counted);
    }
  }
  others_.clear();
  Incarnations live;
  for (const NodeReport& report : reports) {
    const std::string& node_id = report.status.node_id;
    if (node_id != node_id_ && report.incarnation > IncarnationIn(counted, node_id)) {
      others_.push_back(report.status);
      live[node_id] = report.incarnation;
    }
  }
  if (!sends_heartbeats) {
    monitored_.clear();
    silence_.clear();
  } else if (refuted >= incarnation_) {
    incarnation_ = refuted + 1;
    losses_.clear();  // this node was cut off, or stopped: the others decide
    for (auto& [node_id, silence] : silence_) {
      silence = -kFirstHeartbeatTimeout;
    }
  } else if (now >= chosen_ + kMonitorIntervalMin) {
    ChooseMonitored(live);
  }
  return incarnation_ != incarnation_before || losses_ != losses_before;
}

void FailureDetector::AddSilence(absl::Duration elapsed, const std::vector<std::string>& heard) {
  for (auto& [node_id, silence] : silence_) {
    silence += elapsed;
  }
  for (const std::string& node_id : heard) {
    if (const auto node = silence_.find(node_id); node != silence_.end()) {
      node->second = absl::ZeroDuration();
    }
  }
}

// Drops losses of nodes that left, that refuted them, or that are heard again.
void FailureDetector::DropOldLosses(const Incarnations& known,
                                    const std::vector<std::string>& heard) {
  std::erase_if(losses_, [&](const NodeLoss& loss) {
    const auto node = known.find(loss.node_id);
    return node == known.end() || node->second > loss.incarnation ||
           std::find(heard.begin(), heard.end(), loss.node_id) != heard.end();
  });
}

void FailureDetector::AddLosses(const Incarnations& known) {
  for (auto& [node_id, silence] : silence_) {
    const auto node = known.find(node_id);
    if (silence <= kNodeLease || node == known.end() || node->second > kIncarnationMax) {
      continue;
    }
    silence = -kFirstHeartbeatTimeout;
    const NodeLoss loss = {node_id, node->second};
    if (std::find(losses_.begin(), losses_.end(), loss) == losses_.end()) {
      losses_.push_back(loss);
    }
  }
  if (losses_.size() > kLossesMax) {
    losses_.erase(losses_.begin(), losses_.end() - kLossesMax);
  }
}

void FailureDetector::ChooseMonitored(const Incarnations& live) {
  std::vector<std::string> chosen;
  auto node = live.lower_bound(node_id_);
  while (chosen.size() < std::min<size_t>(live.size(), kMonitorsOfNode)) {
    node = std::prev(node == live.begin() ? live.end() : node);
    chosen.push_back(node->first);
  }
  for (const NodeLoss& loss : losses_) {
    if (std::find(chosen.begin(), chosen.end(), loss.node_id) == chosen.end()) {
      chosen.push_back(loss.node_id);
    }
  }
  std::map<std::string, absl::Duration> silence;
  for (const std::string& node_id : chosen) {
    const auto before = silence_.find(node_id);
    silence[node_id] = before == silence_.end() ? -kFirstHeartbeatTimeout : before->second;
  }
  if (chosen != monitored_) {
    monitored_ = std::move(chosen);
    silence_ = std::move(silence);
    chosen_ = updated_;
  }
}

}  // namespace procgen
