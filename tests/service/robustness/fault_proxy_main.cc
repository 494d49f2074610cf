// fault-proxy: a faulty network for tests in other languages. Forwards connections to the server
// with faults until standard input ends, then prints how many it broke.
//
//     fault-proxy 127.0.0.1:PORT SEED BYTES_BETWEEN_FAULTS

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/service/robustness/fault_proxy.h"

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: fault-proxy 127.0.0.1:PORT SEED BYTES_BETWEEN_FAULTS\n");
    return 2;
  }
  procgen::FaultProxy::Options options;
  options.target = argv[1];
  options.seed = static_cast<uint32_t>(std::strtoul(argv[2], nullptr, 10));
  options.bytes_between_faults = std::strtoll(argv[3], nullptr, 10);
  procgen::FaultProxy proxy(options);
  proxy.SetFaults(true);
  std::printf("listening on %s\n", proxy.address().c_str());
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  std::printf("%d broken\n", proxy.break_count());
  return 0;
}
