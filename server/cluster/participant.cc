#include "server/cluster/participant.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "server/cluster/cluster.h"
#include "server/cluster/dds_log.h"
#include "server/cluster/domain_config.h"
#include "server/cluster/domain_qos.h"

namespace procgen {
namespace {

// Cyclone DDS numbers domains within a process, with the number on the network beside. So tests can
// have several nodes in one process.
constexpr dds_domainid_t kProcessDomainsMax = 1000;
// Longest text of a sample, in bytes, and maximum thread count of a node, so that the sum over all
// nodes of a domain cannot overflow.
constexpr size_t kTextBytesMax = 512;
constexpr int32_t kWorkersOfNodeMax = 4096;

// Generated sample types have mutable pointers; the text is not changed.
char* Text(const std::string& text) { return const_cast<char*>(text.c_str()); }

procgen_topics_NodeStatus SampleOf(const NodeStatus& status) {
  return {.node_id = Text(status.node_id),
          .address = Text(status.address),
          .server_version = Text(status.server_version),
          .environment_capacity = status.environment_capacity,
          .env_count = status.env_count,
          .pool_count = status.pool_count,
          .worker_count = status.worker_count,
          .healthy = status.healthy,
          .draining = status.draining,
          .steps_per_second = status.steps_per_second};
}

NodeStatus StatusOf(const procgen_topics_NodeStatus& sample) {
  return {.node_id = sample.node_id,
          .address = sample.address,
          .server_version = sample.server_version,
          .environment_capacity = sample.environment_capacity,
          .env_count = sample.env_count,
          .pool_count = sample.pool_count,
          .worker_count = sample.worker_count,
          .steps_per_second = sample.steps_per_second,
          .healthy = sample.healthy,
          .draining = sample.draining};
}

// Validates samples of others: any process that reaches the ports of the domain can be a node.
bool IsText(const char* text, size_t bytes_max) {
  const size_t bytes = strnlen(text, bytes_max + 1);
  return bytes <= bytes_max && std::all_of(text, text + bytes, [](char letter) {
           return absl::ascii_isprint(static_cast<unsigned char>(letter));
         });
}

bool IsSound(const procgen_topics_NodeStatus& sample) {
  return IsText(sample.node_id, kTextBytesMax) && CheckNodeId(sample.node_id).ok() &&
         IsText(sample.address, kTextBytesMax) && IsText(sample.server_version, kTextBytesMax) &&
         sample.environment_capacity >= 0 && sample.env_count >= 0 && sample.pool_count >= 0 &&
         sample.worker_count >= 0 && sample.worker_count <= kWorkersOfNodeMax &&
         std::isfinite(sample.steps_per_second) && sample.steps_per_second >= 0;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Participant>> Participant::Create(
    const ClusterOptions& options, const std::vector<std::string>& peer_addresses) {
  LogErrorsOfDds();
  std::unique_ptr<Participant> made(new Participant(options));
  absl::Status status = made->CreateDomain(options, peer_addresses);
  if (status.ok()) {
    status = made->CreateTopic();
  }
  if (status.ok()) {
    status = made->CreateWaiting();
  }
  if (!status.ok()) {
    return absl::FailedPreconditionError(absl::StrCat("cannot join cluster ", options.name, ": ",
                                                      status.message(), "; the log says why"));
  }
  return made;
}

absl::Status Participant::CreateDomain(const ClusterOptions& options,
                                       const std::vector<std::string>& peer_addresses) {
  const std::string config = DomainConfig(options, peer_addresses);
  const auto first = static_cast<dds_domainid_t>(options.domain_id);
  dds_domainid_t number = first;
  dds_entity_t domain = dds_create_domain(number, config.c_str());
  while (domain == DDS_RETCODE_PRECONDITION_NOT_MET && number < first + kProcessDomainsMax) {
    ++number;
    domain = dds_create_domain(number, config.c_str());
  }
  if (absl::Status status = domain_.Own(domain, "domain"); !status.ok()) {
    return status;
  }
  return participant_.Own(dds_create_participant(number, nullptr, nullptr), "participant");
}

absl::Status Participant::CreateTopic() {
  const DdsQos partition = PartitionQos(cluster_);
  absl::Status status = publisher_.Own(
      dds_create_publisher(participant_.handle(), partition.get(), nullptr), "publisher");
  status.Update(subscriber_.Own(
      dds_create_subscriber(participant_.handle(), partition.get(), nullptr), "subscriber"));
  if (!status.ok()) {
    return status;
  }
  const DdsQos qos = StatusQos();
  status = nodes_.Create(participant_, publisher_, "procgen_node_status",
                         procgen_topics_NodeStatus_desc, *qos);
  status.Update(nodes_.Subscribe(subscriber_, *qos));
  return status;
}

absl::Status Participant::CreateWaiting() {
  absl::Status status = waiting_.Own(dds_create_waitset(participant_.handle()), "wait set");
  status.Update(wake_.Own(dds_create_guardcondition(participant_.handle()), "condition"));
  status.Update(nodes_.MakeUnreadCondition(&unread_nodes_));
  if (!status.ok()) {
    return status;
  }
  for (const DdsEntity* condition : {&wake_, &unread_nodes_}) {
    dds_waitset_attach(waiting_.handle(), condition->handle(), 0);
  }
  return absl::OkStatus();
}

absl::Status Participant::Write(const NodeStatus& status) const {
  return nodes_.Write(SampleOf(status));
}

std::vector<NodeStatus> Participant::ReadNodes() {
  std::vector<NodeStatus> nodes;
  nodes_.ReadAlive([&](const procgen_topics_NodeStatus& sample) {
    if (IsSound(sample)) {
      nodes.push_back(StatusOf(sample));
    }
  });
  return nodes;
}

void Participant::Wait(absl::Duration timeout) const {
  const absl::Duration wait = std::max(timeout, absl::ZeroDuration());
  dds_waitset_wait(waiting_.handle(), nullptr, 0, absl::ToInt64Nanoseconds(wait));
  dds_set_guardcondition(wake_.handle(), false);
}

void Participant::Wake() const { dds_set_guardcondition(wake_.handle(), true); }

}  // namespace procgen
