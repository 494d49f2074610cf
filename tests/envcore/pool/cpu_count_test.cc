#include "envcore/pool/cpu_count.h"

#include <sched.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "gtest/gtest.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

class CgroupCpuQuotaTest : public testing::Test {
 protected:
  // Writes a file below the mount point.
  void Write(const std::string& path, const std::string& text) const {
    const std::filesystem::path file = std::filesystem::path(mount()) / path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  double Quota(const std::string& memberships) const {
    return CgroupCpuQuota(memberships, mount());
  }
  const std::string& mount() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
};

TEST_F(CgroupCpuQuotaTest, Version2UsesCpuMax) {
  Write("system.slice/procgen.service/cpu.max", "150000 100000\n");
  EXPECT_EQ(Quota("0::/system.slice/procgen.service\n"), 1.5);
}

TEST_F(CgroupCpuQuotaTest, LowestQuotaOfAllParentsCounts) {
  Write("cpu.max", "800000 100000\n");
  Write("pods/cpu.max", "50000 100000\n");
  Write("pods/server/cpu.max", "max 100000\n");
  EXPECT_EQ(Quota("0::/pods/server\n"), 0.5);
}

TEST_F(CgroupCpuQuotaTest, ContainerGroupMayBeTheMountRoot) {
  Write("cpu.max", "200000 100000\n");
  EXPECT_EQ(Quota("0::/\n"), 2);
  EXPECT_EQ(Quota("0::/kubepods/pod1/0123\n"), 2);
}

TEST_F(CgroupCpuQuotaTest, Version1UsesTwoFiles) {
  Write("cpu,cpuacct/docker/1/cpu.cfs_quota_us", "250000\n");
  Write("cpu,cpuacct/docker/1/cpu.cfs_period_us", "100000\n");
  const std::string memberships = "7:memory:/docker/1\n4:cpu,cpuacct:/docker/1\n0::/\n";
  EXPECT_EQ(Quota(memberships), 2.5);
  Write("cpu,cpuacct/docker/1/cpu.cfs_quota_us", "-1\n");
  EXPECT_EQ(Quota(memberships), kNone);
}

TEST_F(CgroupCpuQuotaTest, MissingOrInvalidQuotaIsNone) {
  EXPECT_EQ(Quota("0::/\n"), kNone);
  EXPECT_EQ(Quota(""), kNone);
  EXPECT_EQ(Quota("no line of this kind"), kNone);
  for (const char* text : {"", "max 100000", "max", "0 100000", "100000 0", "-5 100000", "many few",
                           "1 2 3", "99999999999999999999 100000"}) {
    Write("cpu.max", text);
    EXPECT_EQ(Quota("0::/\n"), kNone) << text;
  }
}

TEST(CpuCountTest, IsBoundedByTheAffinity) {
  cpu_set_t before;
  ASSERT_EQ(sched_getaffinity(0, sizeof(before), &before), 0);
  int first = 0;
  while (!CPU_ISSET(first, &before)) {
    ++first;
  }
  EXPECT_LE(CpuCount(), CPU_COUNT(&before));
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
  EXPECT_EQ(CpuCount(), 1);
  ASSERT_EQ(sched_setaffinity(0, sizeof(before), &before), 0);
}

}  // namespace
}  // namespace procgen
