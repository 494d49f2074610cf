#include "server/cluster/domain_qos.h"

#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/cluster/cluster.h"

namespace procgen {
namespace {

// Maximum wait of a writer for memory; not reached, since only the last sample of a key is kept.
constexpr dds_duration_t kWriteTimeout = DDS_MSECS(100);

// Sets one of the three plugins of DDS Security. Debian's libddsc finds them.
void SetPlugin(absl::string_view part, absl::string_view library, absl::string_view functions,
               dds_qos_t* qos) {
  const std::string key = absl::StrCat("dds.sec.", part, ".library.");
  dds_qset_prop(qos, absl::StrCat(key, "path").c_str(), std::string(library).c_str());
  dds_qset_prop(qos, absl::StrCat(key, "init").c_str(), absl::StrCat("init_", functions).c_str());
  dds_qset_prop(qos, absl::StrCat(key, "finalize").c_str(),
                absl::StrCat("finalize_", functions).c_str());
}

void SetFile(absl::string_view name, const std::string& path, dds_qos_t* qos) {
  dds_qset_prop(qos, absl::StrCat("dds.sec.", name).c_str(), absl::StrCat("file:", path).c_str());
}

DdsQos LastOfEachKey() {
  DdsQos qos = MakeQos();
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, absl::ToInt64Nanoseconds(kNodeLease));
  // Leaving unregisters this writer only: a node of the same id may have replaced this one.
  dds_qset_writer_data_lifecycle(qos.get(), /*autodispose=*/false);
  return qos;
}

DdsQos LastOfEachKeyForAll() {
  DdsQos qos = LastOfEachKey();
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, kWriteTimeout);
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  return qos;
}

}  // namespace

DdsQos ParticipantQos(const ClusterOptions& options) {
  DdsQos qos = MakeQos();
  const ClusterSecurity& security = options.security;
  if (security.IsOff()) {
    return qos;
  }
  SetPlugin("auth", "dds_security_auth", "authentication", qos.get());
  SetPlugin("access", "dds_security_ac", "access_control", qos.get());
  SetPlugin("crypto", "dds_security_crypto", "crypto", qos.get());
  SetFile("auth.identity_ca", security.identity_ca, qos.get());
  SetFile("auth.identity_certificate", security.identity_certificate, qos.get());
  SetFile("auth.private_key", security.identity_key, qos.get());
  SetFile("access.permissions_ca", security.permissions_ca, qos.get());
  SetFile("access.governance", security.governance, qos.get());
  SetFile("access.permissions", security.permissions, qos.get());
  return qos;
}

DdsQos PartitionQos(const ClusterOptions& options) {
  DdsQos qos = MakeQos();
  const char* const name = options.name.c_str();
  const char* partitions[] = {name};
  dds_qset_partition(qos.get(), 1, partitions);
  return qos;
}

DdsQos StatusQos() {
  DdsQos qos = LastOfEachKeyForAll();
  dds_qset_lifespan(qos.get(), absl::ToInt64Nanoseconds(kStatusLifespan));
  return qos;
}

DdsQos RatesQos() {
  DdsQos qos = LastOfEachKey();
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_lifespan(qos.get(), absl::ToInt64Nanoseconds(kStatusLifespan));
  return qos;
}

}  // namespace procgen
