#include "server/cluster/domain_qos.h"

#include "absl/time/time.h"
#include "server/cluster/timing.h"

namespace procgen {

DdsQos PartitionQos(const std::string& name) {
  DdsQos qos = MakeQos();
  const char* text = name.c_str();
  dds_qset_partition(qos.get(), 1, &text);
  return qos;
}

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

}  // namespace procgen
