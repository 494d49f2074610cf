#ifndef SERVER_WEB_PLAY_SINGLE_ENV_POOL_H_
#define SERVER_WEB_PLAY_SINGLE_ENV_POOL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "procgen_client/client.h"
#include "server/web/play/page_pool.h"
#include "server/web/play/recording.h"

namespace procgen::web {

// A pool of one environment that a page steps. Threads: one at a time.
class SingleEnvPool {
 public:
  // `spec` has one environment. Errors: those of the server.
  static absl::StatusOr<std::unique_ptr<SingleEnvPool>> Make(
      std::shared_ptr<procgen_client::Client> client, absl::string_view kind,
      const procgen::v1::PoolSpec& spec);
  SingleEnvPool(const SingleEnvPool&) = delete;
  SingleEnvPool& operator=(const SingleEnvPool&) = delete;

  // The spec of the pool, with defaults filled in.
  const procgen::v1::PoolSpec& spec() const { return pool_->spec(); }

  // The methods below block. Errors: those of the server. After an error of Observe, Step or
  // StepAll the pool cannot be stepped. The row of a step that ends an episode also begins the next
  // one: `first` is true, level_seed and picture are of the next episode.

  // The current state, with an image.
  absl::StatusOr<Row> Observe();
  // Steps, with images. `action` is in [-1, 15). If it ends the episode, the row has the last
  // frames, of which the human view has `human_size_px` pixels; 0: no human view.
  absl::StatusOr<Row> Step(int32_t action, int32_t human_size_px);
  // Steps without images. Calls `add` with each row, in order. Steps are pipelined up to actions
  // that end an episode: those whose index satisfies `may_end`. Returns false if another one ended
  // an episode: its row was the last, and the state of the pool is unspecified until Restore.
  absl::StatusOr<bool> StepAll(absl::Span<const int32_t> actions,
                               absl::FunctionRef<bool(size_t)> may_end,
                               absl::FunctionRef<void(const Row&)> add);
  absl::StatusOr<procgen::v1::State> Save();
  absl::Status Restore(const procgen::v1::State& state);
  // A view as a PNG file.
  absl::StatusOr<std::string> Draw(int32_t size_px,
                                   procgen::v1::FrameView view = procgen::v1::FRAME_VIEW_HUMAN);

 private:
  explicit SingleEnvPool(std::unique_ptr<PagePool> pool) : pool_(std::move(pool)) {}

  // Sends a request that returns a batch, or receives one.
  absl::StatusOr<Row> Call(const procgen::v1::RunPoolRequest& request);
  absl::StatusOr<Row> Receive();
  // Begins the next episode, with an image or not, and adds its start to `row`.
  absl::Status BeginEpisode(procgen::v1::Observation observation, Row* row);

  const std::unique_ptr<PagePool> pool_;
  bool has_ended_ = false;  // the last step ended an episode
};

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_SINGLE_ENV_POOL_H_
