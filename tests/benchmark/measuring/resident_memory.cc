#include "tests/benchmark/measuring/resident_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <fstream>

namespace procgen {

int64_t ResidentBytes() {
  malloc_trim(0);
  std::ifstream statm("/proc/self/statm");  // in pages: size, resident, ...
  int64_t size_pages = 0;
  int64_t resident_pages = 0;
  statm >> size_pages >> resident_pages;
  return resident_pages * sysconf(_SC_PAGESIZE);
}

}  // namespace procgen
