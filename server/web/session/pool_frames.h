#ifndef SERVER_WEB_SESSION_POOL_FRAMES_H_
#define SERVER_WEB_SESSION_POOL_FRAMES_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "procgen_client/client.h"
#include "server/concurrency/thread_group.h"
#include "server/web/json/message.h"
#include "server/web/session/difference_cache.h"
#include "server/web/session/frame_encoder.h"
#include "server/web/session/outbox.h"

namespace procgen::web {

// Limits of a watch: environments, frame sizes and rate.
inline constexpr int32_t kWatchEnvironmentsMax = 64;
inline constexpr int32_t kWatchSizePxMin = 16;
inline constexpr int32_t kWatchSizePxMax = 512;
inline constexpr double kFramesPerSecondMax = 60;

// What a page asks to watch.
struct WatchParams {
  procgen::v1::WatchPoolRequest request;
  FrameEncoding encoding = FrameEncoding::kRgb;
};

// Reads the members of watch.start. Reports errors to `params`.
WatchParams ReadWatch(RequestParams* params);

// A watch: sends frames of environments to a page, as fast as it reads, on its own thread.
// Threads: one at a time.
class PoolFrames {
 public:
  // Errors: RESOURCE_EXHAUSTED a thread cannot be started; errors of the server that occur at once.
  // Later ones are reported by the event watch_ended.
  static absl::StatusOr<std::unique_ptr<PoolFrames>> Start(
      std::shared_ptr<procgen_client::Client> client, const WatchParams& params, int64_t number,
      std::shared_ptr<Outbox> outbox, ThreadGroup* threads, DifferenceCache* differences);
  // REQUIRES: Begin was called. No event is sent after the return.
  ~PoolFrames();
  PoolFrames(const PoolFrames&) = delete;
  PoolFrames& operator=(const PoolFrames&) = delete;

  // Allows events, because the page has the number of the watch. Call once.
  void Begin() { shared_->may_begin.Notify(); }
  // Whether the server ended the watch.
  bool has_ended() const { return shared_->has_ended.HasBeenNotified(); }

 private:
  // State shared with the thread.
  struct Shared {
    std::shared_ptr<procgen_client::Client> client;  // before the watch, which it must outlive
    std::unique_ptr<procgen_client::PoolWatch> watch;
    std::shared_ptr<FrameEncoder> encoder;  // used by the outbox
    int64_t number = 0;
    std::shared_ptr<Outbox> outbox;
    absl::Notification may_begin;
    absl::Notification is_stopping;
    absl::Notification has_ended;

    std::string Key() const;
    void Run();
  };

  explicit PoolFrames(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {}

  const std::shared_ptr<Shared> shared_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_POOL_FRAMES_H_
