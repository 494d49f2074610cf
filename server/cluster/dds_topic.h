#ifndef SERVER_CLUSTER_DDS_TOPIC_H_
#define SERVER_CLUSTER_DDS_TOPIC_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "dds/dds.h"
#include "server/cluster/dds_entity.h"

namespace procgen {

// A topic with this node's writer and reader. Sample: its type, generated from topics.idl. The
// reader's memory is the state of the cluster: one instance per key, with its last sample.
// Threads: any method from any thread; reading from one at a time.
template <typename Sample>
class DdsTopic {
 public:
  // Maximum number of instances that are read.
  static constexpr size_t kInstancesMax = 4096;

  // Creates topic and writer. Call once, before anything else. Errors: FAILED_PRECONDITION.
  absl::Status Create(const DdsEntity& participant, const DdsEntity& publisher, const char* name,
                      const dds_topic_descriptor_t& type, const dds_qos_t& qos) {
    const std::string what = absl::StrCat("topic ", name);
    absl::Status status =
        topic_.Own(dds_create_topic(participant.handle(), &type, name, &qos, nullptr), what);
    status.Update(
        writer_.Own(dds_create_writer(publisher.handle(), topic_.handle(), &qos, nullptr), what));
    return status;
  }
  // Creates the reader; without one there is nothing to read. Errors: FAILED_PRECONDITION.
  absl::Status Subscribe(const DdsEntity& subscriber, const dds_qos_t& qos) {
    // No limit of instances: a full reader blocks the writer of its own process.
    return reader_.Own(dds_create_reader(subscriber.handle(), topic_.handle(), &qos, nullptr),
                       "reader");
  }

  // Errors: those of Cyclone DDS.
  absl::Status Write(const Sample& sample) const {
    return StatusOf(dds_write(writer_.handle(), &sample));
  }
  // Calls `use(sample)` for each instance with a live writer that was not disposed.
  template <typename Use>
  void ReadAlive(Use use) {
    // Instances of dead writers would stay in the reader; take them out.
    while (Lend(&dds_take_mask, kDead, [](const Sample&) {}) == kInstancesMax) {
    }
    Lend(&dds_read_mask, kAlive, use);
  }

  // Creates a condition that is ready when there are samples that ReadAlive has not read.
  absl::Status MakeUnreadCondition(DdsEntity* condition) const {
    return condition->Own(
        dds_create_readcondition(reader_.handle(), DDS_NOT_READ_SAMPLE_STATE | DDS_ANY_VIEW_STATE |
                                                       DDS_ANY_INSTANCE_STATE),
        "condition");
  }

 private:
  static constexpr uint32_t kAnyView = DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE;
  static constexpr uint32_t kAlive = kAnyView | DDS_ALIVE_INSTANCE_STATE;
  static constexpr uint32_t kDead =
      kAnyView | DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE | DDS_NOT_ALIVE_NO_WRITERS_INSTANCE_STATE;

  static absl::Status StatusOf(dds_return_t code) {
    return code >= 0 ? absl::OkStatus() : absl::InternalError(dds_strretcode(code));
  }

  // Reads, or takes, the samples in these states, loaned by Cyclone DDS during `use`. Returns their
  // number.
  template <typename Function, typename Use>
  size_t Lend(Function function, uint32_t states, Use use) {
    std::vector<void*> samples(kInstancesMax);
    const int32_t count = function(reader_.handle(), samples.data(), infos_.data(), kInstancesMax,
                                   kInstancesMax, states);
    for (int32_t i = 0; i < count; ++i) {
      const auto at = static_cast<size_t>(i);
      if (infos_[at].valid_data) {
        use(*static_cast<const Sample*>(samples[at]));
      }
    }
    if (count > 0) {
      dds_return_loan(reader_.handle(), samples.data(), count);
    }
    return count > 0 ? static_cast<size_t>(count) : 0;
  }

  DdsEntity topic_;
  DdsEntity writer_;
  DdsEntity reader_;
  std::vector<dds_sample_info_t> infos_ = std::vector<dds_sample_info_t>(kInstancesMax);
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_DDS_TOPIC_H_
