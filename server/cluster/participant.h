#ifndef SERVER_CLUSTER_PARTICIPANT_H_
#define SERVER_CLUSTER_PARTICIPANT_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "dds/dds.h"
#include "server/cluster/cluster_options.h"
#include "server/cluster/node_status.h"

namespace procgen {

// This node in a domain of Cyclone DDS: writes its samples to the topic of topics.idl and reads
// those of the others. Destruction leaves the domain.
// Threads: any method from any thread, but ReadNodes from one at a time.
class Participant {
 public:
  // Maximum number of nodes that are read.
  static constexpr size_t kNodesMax = 4096;

  // `peer_addresses`: of the peers in `options`. Errors: FAILED_PRECONDITION; Cyclone DDS logs the
  // reason.
  static absl::StatusOr<std::unique_ptr<Participant>> Create(
      const ClusterOptions& options, const std::vector<std::string>& peer_addresses);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  absl::Status Write(const NodeStatus& status) const;

  // Returns the last status of all nodes, including this one, that have not left and wrote one
  // within kNodeLease; unordered.
  std::vector<NodeStatus> ReadNodes();

  // Waits until there may be something new to read, a wakeup, or the timeout.
  void Wait(absl::Duration timeout) const;
  void Wake() const;

 private:
  Participant() = default;

  absl::Status Join(const ClusterOptions& options, const std::vector<std::string>& peer_addresses);
  // Reads, or takes, the samples in these states, loaned by Cyclone DDS during `use`. Returns their
  // number.
  template <typename Function, typename Use>
  size_t Lend(Function function, uint32_t states, Use use);

  // Entities of Cyclone DDS. Deleting the domain deletes all others.
  dds_entity_t domain_ = 0;
  dds_entity_t writer_ = 0;
  // Its memory is the state of the cluster: one instance per node, with its last sample.
  dds_entity_t reader_ = 0;
  dds_entity_t wake_ = 0;
  dds_entity_t waiting_ = 0;
  std::vector<dds_sample_info_t> infos_ = std::vector<dds_sample_info_t>(kNodesMax);
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_PARTICIPANT_H_
