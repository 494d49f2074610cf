#ifndef SERVER_CONCURRENCY_CPU_COUNT_H_
#define SERVER_CONCURRENCY_CPU_COUNT_H_

#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// How many cores this process may keep busy: those of its affinity, at most the CPU quota of its
// cgroups rounded up. At least 1.
int CpuCount();

// The least CPU quota, in cores, of the cgroups that `memberships` names (/proc/self/cgroup) and of
// all above them, version 1 or 2, below `mount` (/sys/fs/cgroup). Infinity: there is none, or its
// files make no sense.
double CgroupCpuQuota(absl::string_view memberships, const std::string& mount);

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_CPU_COUNT_H_
