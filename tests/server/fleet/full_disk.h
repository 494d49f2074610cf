#ifndef TESTS_SERVER_FLEET_FULL_DISK_H_
#define TESTS_SERVER_FLEET_FULL_DISK_H_

#include <sys/resource.h>

#include <csignal>
#include <cstdint>

#include "gtest/gtest.h"

namespace procgen {

// While this object lives, no file of the process can grow beyond `bytes`; writes fail as on a full
// disk.
class FullDisk {
 public:
  explicit FullDisk(int64_t bytes = 0) : earlier_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    EXPECT_EQ(getrlimit(RLIMIT_FSIZE, &earlier_), 0);
    rlimit limit = earlier_;
    limit.rlim_cur = static_cast<rlim_t>(bytes);
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &earlier_);
    std::signal(SIGXFSZ, earlier_handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*const earlier_handler_)(int);
  rlimit earlier_ = {};
};

}  // namespace procgen

#endif  // TESTS_SERVER_FLEET_FULL_DISK_H_
