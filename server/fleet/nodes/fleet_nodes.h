#ifndef SERVER_FLEET_NODES_FLEET_NODES_H_
#define SERVER_FLEET_NODES_FLEET_NODES_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "procgen_client/client.h"
#include "server/cluster/node_status.h"
#include "server/concurrency/steady_time.h"
#include "server/fleet/nodes/fleet_options.h"

namespace procgen {

// A connection to a node, and its limits.
struct NodeClient {
  std::string node_id;
  std::string address;
  std::unique_ptr<procgen_client::Client> client;
  v1::Limits limits;
};

// A shard of `env_count` environments on a node.
struct ShardAssignment {
  std::string node_id;
  int32_t env_count = 0;
};

// The nodes for shards: presence, capacity, and connections.
// Threads: any method from any thread. The lock is not held during a call to a node.
class FleetNodes {
 public:
  // Capacity of a node for some environments, which counts as used until this is destroyed.
  class CapacityReservation {
   public:
    CapacityReservation() = default;
    CapacityReservation(FleetNodes* nodes, std::string node_id, int32_t env_count)
        : nodes_(nodes), node_id_(std::move(node_id)), env_count_(env_count) {}
    ~CapacityReservation() { Release(); }
    CapacityReservation(CapacityReservation&& other) noexcept { *this = std::move(other); }
    CapacityReservation& operator=(CapacityReservation&& other) noexcept;
    CapacityReservation(const CapacityReservation&) = delete;
    CapacityReservation& operator=(const CapacityReservation&) = delete;

    const std::string& node_id() const { return node_id_; }

   private:
    void Release();

    FleetNodes* nodes_ = nullptr;  // null: none
    std::string node_id_;
    int32_t env_count_ = 0;
  };

  explicit FleetNodes(FleetOptions options);

  // Divides the `env_count` environments of a new pool among at most `node_count_max` nodes, in
  // proportion to their free capacity.
  // Errors: UNAVAILABLE there is no node; RESOURCE_EXHAUSTED they have too little capacity.
  absl::StatusOr<std::vector<ShardAssignment>> PlanShards(int32_t env_count,
                                                          size_t node_count_max = SIZE_MAX) const;
  // As PlanShards, for an existing pool with shards `own`, whose capacity counts as free. Considers
  // only nodes that this process is connected to, so an announced but unreachable node never moves
  // a pool. Errors: as PlanShards.
  absl::StatusOr<std::vector<ShardAssignment>> PlanRebalance(
      int32_t env_count, const std::vector<ShardAssignment>& own) const;

  // Reserves capacity on `preferred` or, if it has too little, on the node with the most capacity;
  // nodes that have been reached come first. Errors: UNAVAILABLE no node has enough capacity now.
  absl::StatusOr<CapacityReservation> Reserve(int32_t env_count, const std::string& preferred);
  // Returns a connection to a node, opening one if needed. Errors: PERMISSION_DENIED the node
  // rejects this server; UNAVAILABLE and others of the node.
  absl::StatusOr<std::shared_ptr<NodeClient>> Connect(const std::string& node_id);
  // Reports that a node failed. The next Connect opens a new connection, and other nodes are
  // preferred for kNodeSuspicion.
  void Suspect(const std::string& node_id);
  // Reports a wrong answer, described by `why`: the node gets no shards for a while, doubled each
  // time. Logs it and returns an error of the node: UNAVAILABLE.
  absl::Status Distrust(const std::string& node_id, const absl::Status& why);

  // Whether the node can hold shards: it is present, healthy and not draining.
  bool IsUsable(const std::string& node_id) const;
  // Whether a connection to it was opened and has not failed since.
  bool IsConnected(const std::string& node_id) const;
  // Whether it is present, in any state.
  bool IsPresent(const std::string& node_id) const;
  // The present nodes, whether or not they can hold shards.
  std::vector<std::string> Present() const;
  // Number of nodes with shards, a suspicion or a connection.
  size_t known_count() const;
  // Total number of stepping threads of all nodes.
  int32_t worker_count() const;

  // Wakes AwaitChange, and closes connections to nodes that are gone.
  void OnNodesChanged();
  // Waits until OnNodesChanged or `until`, a time of SteadyNow.
  void AwaitChange(absl::Time until) const;

 private:
  // State of a node that has failed or answered wrongly.
  struct Suspicion {
    absl::Time until;                                  // other nodes are preferred
    absl::Time excluded_until = absl::InfinitePast();  // the node is not used at all
    int32_t wrong_answer_count = 0;
  };
  struct Room {
    std::string node_id;
    int64_t free = 0;
    bool is_connected = false;
    bool is_suspect = false;  // other nodes are preferred

    // Lower is better. A node that was connected and failed once comes before one that was never
    // reached.
    int Rank() const { return (is_connected ? 0 : 2) + (is_suspect ? 1 : 0); }
  };

  // REQUIRES: it is used immediately. Drops expired suspicions.
  Suspicion* SuspicionOf(const std::string& node_id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The nodes that can hold shards, by capacity, highest first; excluded nodes are left out.
  std::vector<Room> Rooms(const std::vector<ShardAssignment>& own) const;
  static absl::StatusOr<std::vector<ShardAssignment>> PlanAmong(std::vector<Room> rooms,
                                                                int32_t env_count,
                                                                size_t node_count_max);
  // Opens a connection. Errors: as Connect.
  absl::StatusOr<std::shared_ptr<NodeClient>> MakeClient(const NodeStatus& node);

  const FleetOptions options_;

  mutable absl::Mutex mutex_;
  mutable SteadyCondVar changed_;
  int64_t change_number_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<std::string, int32_t> reserved_ ABSL_GUARDED_BY(mutex_);  // environments by node
  std::map<std::string, Suspicion> suspects_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::shared_ptr<NodeClient>> clients_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_FLEET_NODES_FLEET_NODES_H_
