#ifndef SERVER_CLUSTER_FAILURE_DETECTOR_H_
#define SERVER_CLUSTER_FAILURE_DETECTOR_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "server/cluster/node_status.h"

namespace procgen {

// Nodes that monitor one node.
inline constexpr int kMonitorsOfNode = 3;
// Maximum losses in a report.
inline constexpr int kLossesMax = 64;
// Maximum incarnation in a loss. A node refutes it with the next number.
inline constexpr int64_t kIncarnationMax = int64_t{1} << 53;

// A node whose heartbeats no longer arrive. Every node drops it until the loss is withdrawn, or
// refuted by a higher incarnation.
struct NodeLoss {
  std::string node_id;
  int64_t incarnation = 0;

  friend bool operator==(const NodeLoss&, const NodeLoss&) = default;
};

// What a node publishes: its status, and what it knows of failures.
struct NodeReport {
  NodeStatus status;
  int64_t incarnation = 0;
  std::vector<NodeLoss> losses;
};

// Decides which nodes live, as in SWIM: each node monitors the heartbeats of a few others and
// reports those that it has lost. A lost node that lives refutes that with a higher incarnation.
// So the traffic of a node does not grow with the number of nodes.
// Threads: one at a time.
class FailureDetector {
 public:
  // `node_id`: the local node's.
  explicit FailureDetector(std::string node_id) : node_id_(std::move(node_id)) {}

  // `reports`: the last one of each node. `heard`: the ids of which heartbeats arrived since the
  // last call. `sends_heartbeats`: the local node does; otherwise it monitors and refutes nothing.
  // Returns whether the local node's losses or incarnation changed, so that it has to publish them.
  bool Update(absl::Time now, const std::vector<NodeReport>& reports,
              const std::vector<std::string>& heard, bool sends_heartbeats);

  // The live nodes except the local one, unordered.
  const std::vector<NodeStatus>& others() const { return others_; }
  // The ids of the nodes to monitor: those before the local one in the cyclic order of the ids, and
  // those that it has lost.
  // Changes at most every kMonitorIntervalMin.
  const std::vector<std::string>& monitored() const { return monitored_; }
  int64_t incarnation() const { return incarnation_; }
  const std::vector<NodeLoss>& losses() const { return losses_; }

 private:
  using Incarnations = std::map<std::string, int64_t>;

  void DropOldLosses(const Incarnations& known, const std::vector<std::string>& heard);
  void AddSilence(absl::Duration elapsed, const std::vector<std::string>& heard);
  void AddLosses(const Incarnations& known);
  void ChooseMonitored(const Incarnations& live);

  const std::string node_id_;
  int64_t incarnation_ = 1;
  absl::Time updated_ = absl::InfinitePast();
  absl::Time chosen_ = absl::InfinitePast();  // when the monitored nodes changed
  std::vector<NodeStatus> others_;
  std::vector<std::string> monitored_;
  std::map<std::string, absl::Duration> silence_;  // of the monitored nodes
  std::vector<NodeLoss> losses_;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_FAILURE_DETECTOR_H_
