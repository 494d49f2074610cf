#include "server/cluster/domain_qos.h"

#include <cstdint>

namespace procgen {
namespace {

// Maximum wait of a writer for memory; not reached, since only the last sample of a key is kept.
constexpr dds_duration_t kWriteTimeout = DDS_MSECS(100);

}  // namespace

DdsQos PartitionQos(const std::vector<std::string>& names) {
  DdsQos qos = MakeQos();
  std::vector<const char*> partitions;
  partitions.reserve(names.size());
  for (const std::string& name : names) {
    partitions.push_back(name.c_str());
  }
  dds_qset_partition(qos.get(), static_cast<uint32_t>(partitions.size()), partitions.data());
  return qos;
}

DdsQos StatusQos() {
  DdsQos qos = MakeQos();
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, kWriteTimeout);
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  // Leaving unregisters this writer only: a node of the same id may have replaced this one.
  dds_qset_writer_data_lifecycle(qos.get(), /*autodispose=*/false);
  return qos;
}

DdsQos HeartbeatQos() {
  DdsQos qos = MakeQos();
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  return qos;
}

}  // namespace procgen
