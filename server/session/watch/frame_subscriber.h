#ifndef SERVER_SESSION_WATCH_FRAME_SUBSCRIBER_H_
#define SERVER_SESSION_WATCH_FRAME_SUBSCRIBER_H_

#include <cstdint>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/time/time.h"

namespace procgen {

// What somebody wants to see of a pool.
struct WatchSpec {
  std::vector<int32_t> environments;  // in the order wanted
  int32_t size_px = 0;                // kObservationSizePx: what the agent sees
  absl::Duration interval;            // between two frame sets at least
  int32_t format = 0;                 // of what Encode makes; means nothing here

  bool operator<(const WatchSpec& other) const {
    return std::tie(environments, size_px, interval, format) <
           std::tie(other.environments, other.size_px, other.interval, other.format);
  }
};

// What a pool showed between two requests.
struct FrameSet {
  std::vector<int32_t> environments;
  std::vector<std::string> images;  // uint8 [size_px, size_px, 3], one for each
  int32_t size_px = 0;
  int64_t sequence_number = 0;  // of the last request before it
  absl::Time time;
};

// Makes of a frame set what is sent.
using FrameSetEncoder = std::function<absl::Cord(FrameSet)>;

// Somebody who watches. Threads: any method from any thread; none may block.
class FrameSubscriber {
 public:
  virtual ~FrameSubscriber() = default;

  // Whether it could send another frame set now.
  virtual bool IsReady() = 0;
  // An encoded frame set. If the one before has not been sent, this takes its place.
  virtual void Take(const absl::Cord& frame_set) = 0;
  // There is nothing to watch any more.
  virtual void End(const absl::Status& reason) = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_WATCH_FRAME_SUBSCRIBER_H_
