#include "tests/service/holdings.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace procgen {

Holdings Holdings::Of(pid_t process) {
  const std::string folder = "/proc/" + std::to_string(process);
  int64_t pages = 0;
  int64_t resident_pages = 0;
  std::ifstream(folder + "/statm") >> pages >> resident_pages;
  const std::filesystem::directory_iterator files(folder + "/fd");
  return {resident_pages * sysconf(_SC_PAGESIZE), std::distance(begin(files), end(files))};
}

void HaveFreedMemoryGivenBack() { setenv("ASAN_OPTIONS", "quarantine_size_mb=1", 1); }

}  // namespace procgen
