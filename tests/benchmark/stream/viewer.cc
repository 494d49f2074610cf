// procgen-benchmark-viewer: a subscriber to the first pool of a server, for watch/... of
// procgen-benchmark-stream. A separate process, as a browser is.
#include <atomic>
#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/synchronization/notification.h"
#include "procgen_client/client.h"

namespace procgen {
namespace {

constexpr int32_t kWatchedCount = 16;
constexpr float kFramesPerSecond = 15;
constexpr int32_t kResponseBytesMax = 16 << 20;

// A subscription that ends with this object. The constructor waits for the first frame set, so the
// start of a subscription is not measured.
class Viewer {
 public:
  Viewer(procgen_client::Client* client, const v1::WatchPoolRequest& request)
      : watch_(client->Watch(request)), thread_([this] { Watch(); }) {
    begun_.WaitForNotification();
  }
  ~Viewer() {
    watch_->Stop();
    thread_.join();
  }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  int64_t frame_set_count() const { return frame_set_count_; }

 private:
  void Watch() {
    bool goes_on = watch_->Next().ok();
    begun_.Notify();
    while (goes_on) {
      goes_on = watch_->Next().ok();
      frame_set_count_ += goes_on ? 1 : 0;
    }
  }

  std::atomic<int64_t> frame_set_count_ = 0;
  absl::Notification begun_;
  const std::unique_ptr<procgen_client::PoolWatch> watch_;
  std::thread thread_;
};

absl::Status WatchAsTold(const std::string& address, int32_t size_px) {
  const auto client =
      procgen_client::Client::Connect(address, {.response_bytes_max = kResponseBytesMax});
  if (!client.ok()) {
    return client.status();
  }
  const auto pools = (*client)->ListPools();
  if (!pools.ok()) {
    return pools.status();
  }
  v1::WatchPoolRequest request;
  request.set_pool(pools->front().name());
  for (int32_t i = 0; i < kWatchedCount; ++i) {
    request.add_environments(i);
  }
  request.set_size_px(size_px);
  request.set_frames_per_second_max(kFramesPerSecond);
  request.set_response_bytes_max(kResponseBytesMax);
  std::unique_ptr<Viewer> viewer;
  for (std::string line; std::getline(std::cin, line);) {
    if (viewer == nullptr) {
      viewer = std::make_unique<Viewer>(client->get(), request);
      std::cout << 0 << std::endl;
    } else {
      std::cout << viewer->frame_set_count() << std::endl;
      viewer.reset();
    }
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  int32_t size_px = 0;
  if (argc != 3 || !absl::SimpleAtoi(argv[2], &size_px)) {
    std::cerr << "Usage: procgen-benchmark-viewer SERVER SIZE_PX\n"
                 "Begins to watch 16 environments of the server's first pool with a line of "
                 "standard input, and ends\nwith the next; prints how many frame sets came "
                 "after the first.\n";
    return 2;
  }
  const absl::Status status = procgen::WatchAsTold(argv[1], size_px);
  if (!status.ok()) {
    std::cerr << "procgen-benchmark-viewer: " << status << "\n";
    return 1;
  }
  return 0;
}
