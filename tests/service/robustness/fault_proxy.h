#ifndef TESTS_SERVICE_ROBUSTNESS_FAULT_PROXY_H_
#define TESTS_SERVICE_ROBUSTNESS_FAULT_PROXY_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

namespace procgen {

// A faulty network: a TCP proxy on loopback that injects a fault into each connection after a
// random number of bytes. Faults:
//  - cut: resets both ends;
//  - close: closes both ends;
//  - half-close: one end receives end of file, its own bytes still arrive;
//  - stall: forwards nothing for a while, then cuts;
//  - delay: forwards nothing for a while, then continues.
// The seed determines the faults and their positions in bytes (except faults after silence).
class FaultProxy {
 public:
  struct Options {
    std::string target;  // "127.0.0.1:PORT" of the server
    uint32_t seed = 1;
    int64_t bytes_between_faults = 1000;  // mean, of both directions of a connection
    // Also injects a fault after this silence. 0: never.
    std::chrono::milliseconds silence_max{0};
  };

  explicit FaultProxy(const Options& options);
  // Ends all connections.
  ~FaultProxy();
  FaultProxy(const FaultProxy&) = delete;
  FaultProxy& operator=(const FaultProxy&) = delete;

  // The listening address, "127.0.0.1:PORT".
  const std::string& address() const { return address_; }
  // Turns faults on or off. Off at first.
  void SetFaults(bool enabled);
  // Drops all bytes silently, as a lost network does.
  void Freeze();
  // Number of broken connections: all faults except delays.
  int break_count() const { return break_count_; }

 private:
  class Loop;

  std::atomic<bool> faults_ = false;
  std::atomic<bool> frozen_ = false;
  std::atomic<int> break_count_ = 0;
  std::string address_;
  std::unique_ptr<Loop> loop_;
  int wake_fd_ = -1;  // eventfd that wakes the poll loop
  std::atomic<bool> stops_ = false;
  std::thread thread_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_FAULT_PROXY_H_
