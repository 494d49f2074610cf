#ifndef ENVCORE_POOL_CPU_COUNT_H_
#define ENVCORE_POOL_CPU_COUNT_H_

#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// The number of CPUs that this process can use: those of its affinity, at most the CPU quota of its
// cgroups rounded up. At least 1.
int CpuCount();

// The smallest CPU quota, in CPUs, of the cgroups in `memberships` (/proc/self/cgroup) and their
// ancestors, version 1 or 2, below `mount` (/sys/fs/cgroup). Infinity: there is none, or its files
// are invalid.
double CgroupCpuQuota(absl::string_view memberships, const std::string& mount);

}  // namespace procgen

#endif  // ENVCORE_POOL_CPU_COUNT_H_
