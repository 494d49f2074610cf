#include "server/fleet/nodes/fleet_nodes.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "server/fleet/nodes/node_answers.h"
#include "server/fleet/timing.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

// Smallest shard worth a node of its own, unless capacity is short.
constexpr int32_t kShardEnvCountMin = 4;

absl::Status ReadCredential(const char* flag, const std::string& path, std::string* text) {
  if (path.empty()) {
    return absl::OkStatus();
  }
  std::ifstream file(path, std::ios::binary);
  text->assign(std::istreambuf_iterator<char>(file), {});
  absl::StripAsciiWhitespace(text);
  if (text->empty()) {
    return absl::NotFoundError(
        absl::StrCat("--", flag, " is ", path, ", which is empty or cannot be read"));
  }
  return absl::OkStatus();
}

absl::StatusOr<procgen_client::Credentials> ReadCredentials(const FleetCredentials& paths) {
  procgen_client::Credentials credentials;
  for (const absl::Status& status :
       {ReadCredential("fleet_ca", paths.ca, &credentials.ca),
        ReadCredential("fleet_certificate", paths.certificate, &credentials.certificate),
        ReadCredential("fleet_key", paths.key, &credentials.key),
        ReadCredential("fleet_token", paths.token, &credentials.token)}) {
    if (!status.ok()) {
      return status;
    }
  }
  return credentials;
}

// Converts an error of connecting to a node. If the node rejects this server's credentials:
// PERMISSION_DENIED, since UNAUTHENTICATED would refer to those of this server's caller.
absl::Status NodeError(const NodeStatus& node, bool has_tls, const absl::Status& status) {
  const std::string name = absl::StrCat("node ", node.node_id, " at ", node.address);
  if (absl::IsUnauthenticated(status) || absl::IsPermissionDenied(status)) {
    return absl::PermissionDeniedError(
        absl::StrCat(name, " rejects the fleet server: ", status.message(),
                     "; check --fleet_token and --fleet_certificate"));
  }
  return {status.code(),
          absl::StrCat(name, ", over ", has_tls ? "TLS" : "plain text without --fleet_ca", ": ",
                       status.message())};
}

bool MayHaveShards(const NodeStatus& node) {
  return node.healthy && !node.draining && node.environment_capacity > 0;
}

}  // namespace

absl::Status CheckFleetCredentials(const FleetCredentials& paths) {
  if (paths.certificate.empty() != paths.key.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--fleet_", paths.key.empty() ? "key" : "certificate",
                     " is missing, allowed: --fleet_certificate and --fleet_key, or none of them"));
  }
  if (!paths.certificate.empty() && paths.ca.empty()) {
    return absl::InvalidArgumentError(
        "--fleet_certificate is given without --fleet_ca, which verifies the nodes");
  }
  return ReadCredentials(paths).status();
}

FleetNodes::CapacityReservation& FleetNodes::CapacityReservation::operator=(
    CapacityReservation&& other) noexcept {
  if (this != &other) {
    Release();
    nodes_ = std::exchange(other.nodes_, nullptr);
    node_id_ = std::move(other.node_id_);
    env_count_ = other.env_count_;
  }
  return *this;
}

void FleetNodes::CapacityReservation::Release() {
  if (FleetNodes* nodes = std::exchange(nodes_, nullptr); nodes != nullptr) {
    absl::MutexLock lock(&nodes->mutex_);
    const auto reserved = nodes->reserved_.find(node_id_);
    reserved->second -= env_count_;
    if (reserved->second == 0) {
      nodes->reserved_.erase(reserved);
    }
  }
}

FleetNodes::FleetNodes(FleetOptions options) : options_(std::move(options)) {}

std::vector<FleetNodes::Room> FleetNodes::Rooms(const std::vector<ShardAssignment>& own) const {
  const std::vector<NodeStatus> nodes = options_.nodes();
  std::vector<Room> rooms;
  {
    absl::MutexLock lock(&mutex_);
    const absl::Time now = options_.clock();
    for (const NodeStatus& node : nodes) {
      if (!MayHaveShards(node)) {
        continue;
      }
      // A node's report may be a second old and does not include what was placed on it since.
      const auto reserved = reserved_.find(node.node_id);
      int64_t used = std::max(node.env_count, reserved == reserved_.end() ? 0 : reserved->second);
      for (const ShardAssignment& assignment : own) {
        used -= assignment.node_id == node.node_id ? assignment.env_count : 0;
      }
      const auto suspect = suspects_.find(node.node_id);
      if (suspect != suspects_.end() && suspect->second.excluded_until > now) {
        continue;
      }
      rooms.push_back({.node_id = node.node_id,
                       .free = node.environment_capacity - std::max<int64_t>(used, 0),
                       .is_connected = clients_.contains(node.node_id),
                       .is_suspect = suspect != suspects_.end() && suspect->second.until > now});
    }
  }
  std::stable_sort(rooms.begin(), rooms.end(),
                   [](const Room& left, const Room& right) { return left.free > right.free; });
  return rooms;
}

absl::StatusOr<std::vector<ShardAssignment>> FleetNodes::PlanShards(int32_t env_count,
                                                                    size_t node_count_max) const {
  std::vector<Room> rooms = Rooms({});
  const auto is_suspect = [](const Room& room) { return room.is_suspect; };
  if (!std::all_of(rooms.begin(), rooms.end(), is_suspect)) {
    std::erase_if(rooms, is_suspect);
  }
  return PlanAmong(std::move(rooms), env_count, node_count_max);
}

absl::StatusOr<std::vector<ShardAssignment>> FleetNodes::PlanRebalance(
    int32_t env_count, const std::vector<ShardAssignment>& own) const {
  std::vector<Room> rooms = Rooms(own);
  std::erase_if(rooms, [](const Room& room) { return room.Rank() > 0; });
  return PlanAmong(std::move(rooms), env_count, SIZE_MAX);
}

absl::StatusOr<std::vector<ShardAssignment>> FleetNodes::PlanAmong(std::vector<Room> rooms,
                                                                   int32_t env_count,
                                                                   size_t node_count_max) {
  if (rooms.empty()) {
    return absl::UnavailableError("the fleet has no node at the moment; retry later");
  }
  const auto worth = static_cast<size_t>(std::max(1, env_count / kShardEnvCountMin));
  int64_t free = 0;
  size_t room_count = 0;
  while (room_count < std::min(rooms.size(), node_count_max) &&
         (room_count < worth || free < env_count)) {
    free += std::max<int64_t>(rooms[room_count++].free, 0);
  }
  if (free < env_count) {
    const std::string nodes =
        room_count == rooms.size()
            ? "the fleet's nodes"
            : absl::StrCat("the fleet has threads left for ", room_count, " shards, whose nodes");
    return absl::ResourceExhaustedError(absl::StrCat(
        "spec.env_count is ", env_count, " and ", nodes, " have room for ", free, " environments"));
  }
  rooms.resize(room_count);
  std::vector<ShardAssignment> assignments;
  int32_t left = env_count;
  for (const Room& room : rooms) {
    const int64_t room_free = std::max<int64_t>(room.free, 0);
    if (left > 0 && room_free > 0) {
      // In proportion to the remaining capacity, rounded up so that nothing is left over.
      const auto count = static_cast<int32_t>((left * room_free + free - 1) / free);
      assignments.push_back({room.node_id, count});
      left -= count;
    }
    free -= room_free;
  }
  return assignments;
}

absl::StatusOr<FleetNodes::CapacityReservation> FleetNodes::Reserve(int32_t env_count,
                                                                    const std::string& preferred) {
  std::vector<Room> rooms = Rooms({});
  std::stable_sort(rooms.begin(), rooms.end(), [&](const Room& left, const Room& right) {
    const auto rank = [&](const Room& room) {
      return room.node_id == preferred && !room.is_suspect ? -1 : room.Rank();
    };
    return rank(left) < rank(right);
  });
  for (const Room& room : rooms) {
    if (room.free >= env_count) {
      absl::MutexLock lock(&mutex_);
      reserved_[room.node_id] += env_count;
      return CapacityReservation(this, room.node_id, env_count);
    }
  }
  return absl::UnavailableError(
      absl::StrCat("none of ", rooms.size(), " nodes has room for ", env_count, " environments"));
}

absl::StatusOr<std::shared_ptr<NodeClient>> FleetNodes::Connect(const std::string& node_id) {
  const std::vector<NodeStatus> nodes = options_.nodes();
  const auto node = std::find_if(nodes.begin(), nodes.end(),
                                 [&](const NodeStatus& each) { return each.node_id == node_id; });
  if (node == nodes.end()) {
    return absl::UnavailableError(absl::StrCat("node ", node_id, " is gone"));
  }
  {
    absl::MutexLock lock(&mutex_);
    // A node of that name may have returned at another address.
    if (const auto found = clients_.find(node_id);
        found != clients_.end() && found->second->address == node->address) {
      return found->second;
    }
  }
  absl::StatusOr<std::shared_ptr<NodeClient>> connected = MakeClient(*node);
  if (!connected.ok()) {
    Suspect(node_id);
    return connected.status();
  }
  std::shared_ptr<NodeClient> last = *connected;  // destroyed outside the lock
  absl::MutexLock lock(&mutex_);
  clients_[node_id].swap(last);
  return connected;
}

absl::StatusOr<std::shared_ptr<NodeClient>> FleetNodes::MakeClient(const NodeStatus& node) {
  absl::StatusOr<procgen_client::Credentials> credentials = ReadCredentials(options_.credentials);
  if (!credentials.ok()) {
    return credentials.status();
  }
  procgen_client::ConnectOptions options;
  options.timeout = kNodeConnectTimeout;
  options.response_bytes_max = std::numeric_limits<int32_t>::max();
  options.credentials = *std::move(credentials);
  options.keepalive_time = kNodeKeepaliveTime;
  options.keepalive_timeout = kNodeKeepaliveTimeout;
  options.call_timeout = kNodeCallTimeout;
  const bool has_tls = !options_.credentials.ca.empty();
  auto client = procgen_client::Client::Connect(node.address, options);
  if (!client.ok()) {
    return NodeError(node, has_tls, client.status());
  }
  absl::StatusOr<v1::Catalog> catalog = (*client)->GetCatalog();
  if (!catalog.ok()) {
    return NodeError(node, has_tls, catalog.status());
  }
  if (absl::Status status = CheckNodeLimits(catalog->limits()); !status.ok()) {
    return Distrust(node.node_id, status);
  }
  return std::make_shared<NodeClient>(
      NodeClient{node.node_id, node.address, *std::move(client), catalog->limits()});
}

void FleetNodes::Suspect(const std::string& node_id) {
  std::shared_ptr<NodeClient> last;  // destroyed outside the lock
  absl::MutexLock lock(&mutex_);
  SuspicionOf(node_id)->until = options_.clock() + kNodeSuspicion;
  if (const auto found = clients_.find(node_id); found != clients_.end()) {
    last = std::move(found->second);
    clients_.erase(found);
  }
}

FleetNodes::Suspicion* FleetNodes::SuspicionOf(const std::string& node_id) {
  const absl::Time forgotten = options_.clock() - kNodeExclusionMax;
  std::erase_if(suspects_, [forgotten](const auto& suspect) {
    return std::max(suspect.second.until, suspect.second.excluded_until) < forgotten;
  });
  return &suspects_[node_id];
}

absl::Status FleetNodes::Distrust(const std::string& node_id, const absl::Status& why) {
  absl::Duration excluded = kNodeExclusionMin;
  {
    absl::MutexLock lock(&mutex_);
    Suspicion* const suspicion = SuspicionOf(node_id);
    for (int32_t i = suspicion->wrong_answer_count; i > 0 && excluded < kNodeExclusionMax; --i) {
      excluded = std::min(2 * excluded, kNodeExclusionMax);
    }
    ++suspicion->wrong_answer_count;
    suspicion->excluded_until = options_.clock() + excluded;
  }
  LogEvent(LogLevel::kError, "node_distrusted",
           {{"node", node_id},
            {"excluded", absl::FormatDuration(excluded)},
            {"message", std::string(why.message())}});
  return absl::UnavailableError(
      absl::StrCat("node ", node_id, " sent an invalid answer: ", why.message()));
}

bool FleetNodes::IsUsable(const std::string& node_id) const {
  const std::vector<NodeStatus> nodes = options_.nodes();
  return std::any_of(nodes.begin(), nodes.end(), [&](const NodeStatus& node) {
    return node.node_id == node_id && MayHaveShards(node);
  });
}

bool FleetNodes::IsConnected(const std::string& node_id) const {
  absl::MutexLock lock(&mutex_);
  return clients_.contains(node_id);
}

bool FleetNodes::IsPresent(const std::string& node_id) const {
  const std::vector<NodeStatus> nodes = options_.nodes();
  return std::any_of(nodes.begin(), nodes.end(),
                     [&](const NodeStatus& node) { return node.node_id == node_id; });
}

std::vector<std::string> FleetNodes::Present() const {
  std::vector<std::string> present;
  for (const NodeStatus& node : options_.nodes()) {
    if (node.environment_capacity > 0) {
      present.push_back(node.node_id);
    }
  }
  return present;
}

int32_t FleetNodes::worker_count() const {
  int32_t count = 0;
  for (const NodeStatus& node : options_.nodes()) {
    count += MayHaveShards(node) ? node.worker_count : 0;
  }
  return count;
}

size_t FleetNodes::known_count() const {
  absl::MutexLock lock(&mutex_);
  std::set<std::string> known;
  for (const auto& [node_id, count] : reserved_) {
    known.insert(node_id);
  }
  for (const auto& [node_id, suspicion] : suspects_) {
    known.insert(node_id);
  }
  for (const auto& [node_id, client] : clients_) {
    known.insert(node_id);
  }
  return known.size();
}

void FleetNodes::OnNodesChanged() {
  std::set<std::string> present;
  for (const NodeStatus& node : options_.nodes()) {
    present.insert(node.node_id);
  }
  std::vector<std::shared_ptr<NodeClient>> gone;  // destroyed outside the lock
  absl::MutexLock lock(&mutex_);
  std::erase_if(clients_, [&](auto& each) {
    const bool is_gone = !present.contains(each.first);
    if (is_gone) {
      gone.push_back(std::move(each.second));
    }
    return is_gone;
  });
  ++change_number_;
  changed_.NotifyAll();
}

void FleetNodes::AwaitChange(absl::Time until) const {
  absl::MutexLock lock(&mutex_);
  const int64_t before = change_number_;
  changed_.AwaitUntil(&mutex_, until, [this, before]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return change_number_ != before;
  });
}

}  // namespace procgen
