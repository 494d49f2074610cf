#include "tests/service/robustness/process_resources.h"

#include <malloc.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

// Functions of the sanitizers' allocators, which malloc.h does not cover; null without them.
// NOLINTNEXTLINE(bugprone-reserved-identifier): its name in the runtime of each of them.
extern "C" size_t __sanitizer_get_current_allocated_bytes() __attribute__((weak));

namespace procgen {

ProcessResources ProcessResources::Of(pid_t process) {
  const std::string folder = "/proc/" + std::to_string(process);
  int64_t pages = 0;
  int64_t resident_pages = 0;
  std::ifstream(folder + "/statm") >> pages >> resident_pages;
  const std::filesystem::directory_iterator files(folder + "/fd");
  return {resident_pages * sysconf(_SC_PAGESIZE), std::distance(begin(files), end(files))};
}

int64_t AllocatedBytes() {
  if (__sanitizer_get_current_allocated_bytes != nullptr) {
    return static_cast<int64_t>(__sanitizer_get_current_allocated_bytes());
  }
  const struct mallinfo2 info = mallinfo2();
  return static_cast<int64_t>(info.uordblks + info.hblkhd);
}

void ReturnFreedMemoryAtOnce() { setenv("ASAN_OPTIONS", "quarantine_size_mb=1", 1); }

}  // namespace procgen
