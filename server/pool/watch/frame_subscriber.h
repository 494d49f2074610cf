#ifndef SERVER_POOL_WATCH_FRAME_SUBSCRIBER_H_
#define SERVER_POOL_WATCH_FRAME_SUBSCRIBER_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/time/time.h"
#include "server/pool/episodes/annotation.h"

namespace procgen {

// What a subscriber sees of a pool.
struct WatchSpec {
  std::vector<int32_t> environments;  // in the order of the images
  int32_t size_px = 0;                // kObservationSizePx: the agent's view
  absl::Duration interval;            // minimum time between two frame sets
  int32_t format = 0;                 // format of the encoder's output; opaque here
  bool with_steps = false;            // frame sets contain the newest steps
  bool with_agent_views = false;      // and the agent's views; not if `images` are those

  bool operator<(const WatchSpec& other) const {
    return std::tie(environments, size_px, interval, format, with_steps, with_agent_views) <
           std::tie(other.environments, other.size_px, other.interval, other.format,
                    other.with_steps, other.with_agent_views);
  }
};

// A step of one environment, or the start of an episode.
struct EnvironmentStep {
  std::optional<int32_t> action;  // absent: the start
  float reward = 0;
  float episode_return = 0;    // so far
  int32_t episode_length = 0;  // steps so far
  int32_t level_seed = 0;      // of the level in the image
  std::vector<EnvironmentAnnotation> annotations;
};

// An episode that has ended, as viewers see it.
struct FinishedEpisode {
  float episode_return = 0;
  int32_t length = 0;           // steps
  int32_t level_seed = 0;       // of its last level
  bool level_complete = false;  // its last step completed the level
  bool truncated = false;       // the step limit ended it
};

// The images of a pool's environments between two requests.
struct FrameSet {
  std::vector<int32_t> environments;
  std::vector<std::string> images;  // uint8 [size_px, size_px, 3], one for each
  // uint8 [64, 64, 3], of the same states as `images`, one for each; empty unless the spec asks for
  // them.
  std::vector<std::string> agent_images;
  // One for each. If set, the image shows the last state of this episode, not the current state.
  std::vector<std::optional<FinishedEpisode>> ended_episodes;
  // One for each, if the spec asks for steps. Absent: no step is known.
  std::vector<std::optional<EnvironmentStep>> steps;
  int32_t size_px = 0;
  int64_t request_count = 0;  // of the pool, before it
  absl::Time time;
};

// Serialises a frame set for sending.
using FrameSetEncoder = std::function<absl::Cord(FrameSet)>;

// A subscriber. Threads: any method from any thread; none may block.
class FrameSubscriber {
 public:
  virtual ~FrameSubscriber() = default;

  // Whether it can send another frame set now.
  virtual bool IsReady() = 0;
  // Receives an encoded frame set. It replaces the previous one if that has not been sent.
  virtual void Take(const absl::Cord& frame_set) = 0;
  // The subscription has ended; no more frame sets follow.
  virtual void End(const absl::Status& reason) = 0;
};

}  // namespace procgen

#endif  // SERVER_POOL_WATCH_FRAME_SUBSCRIBER_H_
