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
#include "server/cluster/timing.h"
#include "server/cluster/topics.h"

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

// Quality-of-service settings; README.md gives the reasons.
using DdsQos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;
DdsQos MakeQos() { return {dds_create_qos(), &dds_delete_qos}; }

// Of publisher and subscriber.
DdsQos PartitionQos(const std::string& name) {
  DdsQos qos = MakeQos();
  const char* text = name.c_str();
  dds_qset_partition(qos.get(), 1, &text);
  return qos;
}

// Of the topic, its writer and its reader.
DdsQos StatusQos() {
  DdsQos qos = MakeQos();
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  // Readers drop the status of a node that does not repeat it.
  dds_qset_lifespan(qos.get(), absl::ToInt64Nanoseconds(kNodeLease));
  // Leaving unregisters this writer only: a node of the same id may have replaced this one.
  dds_qset_writer_data_lifecycle(qos.get(), /*autodispose=*/false);
  return qos;
}

// Checks what a function of Cyclone DDS returned: an entity, or an error.
absl::Status CheckMade(absl::string_view what, dds_return_t result) {
  return result >= 0 ? absl::OkStatus()
                     : absl::FailedPreconditionError(absl::StrCat("Cyclone DDS makes no ", what,
                                                                  ": ", dds_strretcode(result)));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Participant>> Participant::Create(
    const ClusterOptions& options, const std::vector<std::string>& peer_addresses) {
  LogErrorsOfDds();
  std::unique_ptr<Participant> made(new Participant);
  if (absl::Status status = made->Join(options, peer_addresses); !status.ok()) {
    return absl::FailedPreconditionError(absl::StrCat("cannot join cluster ", options.name, ": ",
                                                      status.message(), "; the log says why"));
  }
  return made;
}

Participant::~Participant() {
  if (domain_ > 0) {
    dds_delete(domain_);
  }
}

absl::Status Participant::Join(const ClusterOptions& options,
                               const std::vector<std::string>& peer_addresses) {
  const std::string config = DomainConfig(options, peer_addresses);
  const auto first = static_cast<dds_domainid_t>(options.domain_id);
  dds_domainid_t number = first;
  domain_ = dds_create_domain(number, config.c_str());
  while (domain_ == DDS_RETCODE_PRECONDITION_NOT_MET && number < first + kProcessDomainsMax) {
    ++number;
    domain_ = dds_create_domain(number, config.c_str());
  }
  if (absl::Status status = CheckMade("domain", domain_); !status.ok()) {
    return status;
  }
  const DdsQos partition = PartitionQos(options.name);
  const DdsQos qos = StatusQos();
  // After an error the following ones fail, too.
  const dds_entity_t participant = dds_create_participant(number, nullptr, nullptr);
  const dds_entity_t publisher = dds_create_publisher(participant, partition.get(), nullptr);
  const dds_entity_t subscriber = dds_create_subscriber(participant, partition.get(), nullptr);
  const dds_entity_t topic = dds_create_topic(participant, &procgen_topics_NodeStatus_desc,
                                              "procgen_node_status", qos.get(), nullptr);
  writer_ = dds_create_writer(publisher, topic, qos.get(), nullptr);
  // No limit of instances: a full reader blocks the writer of its own process.
  reader_ = dds_create_reader(subscriber, topic, qos.get(), nullptr);
  const dds_entity_t unread = dds_create_readcondition(
      reader_, DDS_NOT_READ_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ANY_INSTANCE_STATE);
  wake_ = dds_create_guardcondition(participant);
  waiting_ = dds_create_waitset(participant);
  absl::Status status = CheckMade("participant", participant);
  status.Update(CheckMade("publisher", publisher));
  status.Update(CheckMade("subscriber", subscriber));
  status.Update(CheckMade("topic", topic));
  status.Update(CheckMade("writer", writer_));
  status.Update(CheckMade("reader", reader_));
  for (const dds_entity_t condition : {wake_, unread}) {
    status.Update(CheckMade("condition", condition));
    status.Update(CheckMade("wait set", dds_waitset_attach(waiting_, condition, 0)));
  }
  return status;
}

absl::Status Participant::Write(const NodeStatus& status) const {
  const procgen_topics_NodeStatus sample = SampleOf(status);
  const dds_return_t code = dds_write(writer_, &sample);
  return code >= 0 ? absl::OkStatus() : absl::InternalError(dds_strretcode(code));
}

std::vector<NodeStatus> Participant::ReadNodes() {
  constexpr uint32_t kAny = DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE;
  constexpr uint32_t kDead =
      DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE | DDS_NOT_ALIVE_NO_WRITERS_INSTANCE_STATE;
  // Instances of dead writers would stay in the reader; take them out.
  while (Lend(&dds_take_mask, kAny | kDead, [](const auto&) {}) == kNodesMax) {
  }
  std::vector<NodeStatus> nodes;
  Lend(&dds_read_mask, kAny | DDS_ALIVE_INSTANCE_STATE,
       [&](const procgen_topics_NodeStatus& sample) {
         if (IsSound(sample)) {
           nodes.push_back(StatusOf(sample));
         }
       });
  return nodes;
}

template <typename Function, typename Use>
size_t Participant::Lend(Function function, uint32_t states, Use use) {
  std::vector<void*> samples(kNodesMax);
  const int32_t count =
      function(reader_, samples.data(), infos_.data(), kNodesMax, kNodesMax, states);
  for (int32_t i = 0; i < count; ++i) {
    const auto at = static_cast<size_t>(i);
    if (infos_[at].valid_data) {
      use(*static_cast<const procgen_topics_NodeStatus*>(samples[at]));
    }
  }
  if (count > 0) {
    dds_return_loan(reader_, samples.data(), count);
  }
  return count > 0 ? static_cast<size_t>(count) : 0;
}

void Participant::Wait(absl::Duration timeout) const {
  const absl::Duration wait = std::max(timeout, absl::ZeroDuration());
  dds_waitset_wait(waiting_, nullptr, 0, absl::ToInt64Nanoseconds(wait));
  dds_set_guardcondition(wake_, false);
}

void Participant::Wake() const { dds_set_guardcondition(wake_, true); }

}  // namespace procgen
