#include "envcore/pool/cpu_count.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <sstream>
#include <thread>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace procgen {
namespace {

constexpr double kNoQuota = std::numeric_limits<double>::infinity();

// Returns an empty string if the file does not exist.
std::string ReadFile(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// `quota_us`: CPU time in us per period.
double QuotaOf(absl::string_view quota_us, absl::string_view period_us) {
  int64_t quota = 0;
  int64_t period = 0;
  return absl::SimpleAtoi(quota_us, &quota) && absl::SimpleAtoi(period_us, &period) && quota > 0 &&
                 period > 0
             ? static_cast<double>(quota) / static_cast<double>(period)
             : kNoQuota;  // "max", or -1
}

// The quota of one cgroup.
double QuotaOfVersion2(const std::string& folder) {
  const std::string text = ReadFile(absl::StrCat(folder, "/cpu.max"));
  const std::vector<absl::string_view> words =
      absl::StrSplit(text, absl::ByAnyChar(" \n"), absl::SkipEmpty());
  return words.size() == 2 ? QuotaOf(words[0], words[1]) : kNoQuota;
}

double QuotaOfVersion1(const std::string& folder) {
  return QuotaOf(ReadFile(absl::StrCat(folder, "/cpu.cfs_quota_us")),
                 ReadFile(absl::StrCat(folder, "/cpu.cfs_period_us")));
}

// The smallest quota of a cgroup and its ancestors. In a container, the path may be the one
// outside, with only the container's cgroup at `mount`: then that is used.
template <typename QuotaOfGroup>
double LeastQuota(const std::string& mount, absl::string_view path, QuotaOfGroup quota_of) {
  double least = quota_of(mount);
  std::string folder = mount;
  for (const absl::string_view name : absl::StrSplit(path, '/', absl::SkipEmpty())) {
    absl::StrAppend(&folder, "/", name);
    least = std::min(least, quota_of(folder));
  }
  return least;
}

int AffinityCount() {
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof(cores), &cores) != 0) {
    return static_cast<int>(std::thread::hardware_concurrency());  // more CPUs than cpu_set_t holds
  }
  return CPU_COUNT(&cores);
}

}  // namespace

double CgroupCpuQuota(absl::string_view memberships, const std::string& mount) {
  double least = kNoQuota;
  // ID:CONTROLLERS:PATH; empty CONTROLLERS: version 2.
  for (const absl::string_view line : absl::StrSplit(memberships, '\n', absl::SkipEmpty())) {
    const std::vector<absl::string_view> parts = absl::StrSplit(line, absl::MaxSplits(':', 2));
    if (parts.size() != 3) {
      continue;
    }
    if (parts[1].empty()) {
      least = std::min(least, LeastQuota(mount, parts[2], QuotaOfVersion2));
    }
    for (const absl::string_view controller : absl::StrSplit(parts[1], ',')) {
      if (controller == "cpu") {
        for (const absl::string_view folder : {parts[1], controller}) {
          least = std::min(least,
                           LeastQuota(absl::StrCat(mount, "/", folder), parts[2], QuotaOfVersion1));
        }
      }
    }
  }
  return least;
}

int CpuCount() {
  const double quota = CgroupCpuQuota(ReadFile("/proc/self/cgroup"), "/sys/fs/cgroup");
  const int affinity = std::max(1, AffinityCount());
  return quota < affinity ? std::max(1, static_cast<int>(std::ceil(quota))) : affinity;
}

}  // namespace procgen
