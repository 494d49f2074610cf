#include "tests/service/holdings.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace procgen {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kTellsMemory = false;
#else
constexpr bool kTellsMemory = true;
#endif

}  // namespace

Holdings Holdings::Of(pid_t process) {
  const std::string folder = "/proc/" + std::to_string(process);
  int64_t pages = 0;
  int64_t resident_pages = 0;
  std::ifstream(folder + "/statm") >> pages >> resident_pages;
  const std::filesystem::directory_iterator files(folder + "/fd");
  return {kTellsMemory ? resident_pages * sysconf(_SC_PAGESIZE) : 0,
          std::distance(begin(files), end(files))};
}

}  // namespace procgen
