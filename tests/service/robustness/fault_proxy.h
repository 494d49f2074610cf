#ifndef TESTS_SERVICE_ROBUSTNESS_FAULT_PROXY_H_
#define TESTS_SERVICE_ROBUSTNESS_FAULT_PROXY_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

namespace procgen {

// A bad network: a TCP proxy on loopback that harms the connections through it after random numbers
// of bytes. It
//  - cuts: resets both ends;
//  - closes: ends both;
//  - half-closes: one end receives end of file, its own bytes still arrive;
//  - stalls: for a while nothing passes, then it cuts;
//  - delays: for a while nothing passes, then it continues.
// What it does and when, in bytes, follows from the seed (but not when a connection is silent).
class FaultProxy {
 public:
  struct Options {
    std::string target;  // "127.0.0.1:PORT" of the server
    uint32_t seed = 1;
    int64_t bytes_between_faults = 1000;  // in the mean, of a connection, both ways together
    // Harms connections that were silent for so long, too; 0: not for that.
    std::chrono::milliseconds silence_max{0};
  };

  explicit FaultProxy(const Options& options);
  // Ends all connections.
  ~FaultProxy();
  FaultProxy(const FaultProxy&) = delete;
  FaultProxy& operator=(const FaultProxy&) = delete;

  // Where it listens, "127.0.0.1:PORT".
  const std::string& address() const { return address_; }
  // Until the first call with true, all bytes pass.
  void SetFaults(bool enabled);
  // Drops everything silently, as a lost network does.
  void Freeze();
  // Connections that it broke: all faults but delays.
  int break_count() const { return break_count_; }

 private:
  class Loop;

  std::atomic<bool> faults_ = false;
  std::atomic<bool> frozen_ = false;
  std::atomic<int> break_count_ = 0;
  std::string address_;
  std::unique_ptr<Loop> loop_;
  int wake_fd_ = -1;  // readable: look again
  std::atomic<bool> stops_ = false;
  std::thread thread_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_FAULT_PROXY_H_
