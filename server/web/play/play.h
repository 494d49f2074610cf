#ifndef SERVER_WEB_PLAY_PLAY_H_
#define SERVER_WEB_PLAY_PLAY_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/web/play/level_choice.h"
#include "server/web/play/recording.h"
#include "server/web/play/replay.h"
#include "server/web/play/single_env_pool.h"

namespace procgen::web {

// Sizes of the human view in pixels; 0 means no human view.
inline constexpr int32_t kHumanSizePxMin = 64;
inline constexpr int32_t kHumanSizePxMax = 1024;
inline constexpr int32_t kHumanSizePxDefault = 512;

// Composes a view: its JSON, the agent image, the human image of that size, and the final ones of
// `row`.
absl::StatusOr<Answer> ViewAnswer(Json view, Row row, SingleEnvPool* pool, int32_t human_size_px);

// Reads human_size_px of a request.
int32_t ReadHumanSize(RequestParams* params);

// A level that a viewer plays, with its recording. All methods block. Threads: one at a time.
class Play {
 public:
  // Maximum number of actions of one recording, about two hours at 15 steps per second.
  static constexpr int32_t kStepsMax = 100000;

  // Errors: those of the server.
  static absl::StatusOr<std::unique_ptr<Play>> Start(std::shared_ptr<procgen_client::Client> client,
                                                     const LevelChoice& choice,
                                                     int32_t human_size_px);
  // Continues a replay at a row. Restart returns to that row; NextLevel starts the level after the
  // row's. Errors: those of the server.
  static absl::StatusOr<std::unique_ptr<Play>> Continue(
      std::shared_ptr<procgen_client::Client> client, Branch branch, int32_t human_size_px);

  // Each returns a view. Errors: those of the server; RESOURCE_EXHAUSTED the recording is full;
  // FAILED_PRECONDITION there is no next level.
  absl::StatusOr<Answer> View();
  absl::StatusOr<Answer> Step(int32_t action);
  absl::StatusOr<Answer> Restart();
  absl::StatusOr<Answer> NextLevel();

  // Sets the size of later human views. REQUIRES: a size that ReadHumanSize may return.
  void set_human_size_px(int32_t size_px) { human_size_px_ = size_px; }

  const Recording& recording() const { return recording_; }

 private:
  Play(std::shared_ptr<procgen_client::Client> client, LevelChoice choice, int32_t human_size_px,
       std::unique_ptr<SingleEnvPool> pool, Recording recording);
  // Starts the recording at the current state of the pool.
  absl::Status Begin();
  // Makes the current state the one that Restart returns to.
  void SetStart(procgen::v1::State state);

  const std::shared_ptr<procgen_client::Client> client_;
  LevelChoice choice_;
  int32_t human_size_px_;
  std::unique_ptr<SingleEnvPool> pool_;
  Recording recording_;
  Row row_;  // the latest
  // For Restart.
  procgen::v1::State start_;
  Recording start_recording_;
  Row start_row_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_PLAY_H_
