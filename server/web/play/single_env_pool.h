#ifndef SERVER_WEB_PLAY_SINGLE_ENV_POOL_H_
#define SERVER_WEB_PLAY_SINGLE_ENV_POOL_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "procgen_client/client.h"
#include "server/web/play/recording.h"

namespace procgen::web {

// Creates a pool for a page, named "pools/web-KIND-...", with a short lease.
absl::StatusOr<procgen::v1::Pool> MakePagePool(procgen_client::Client* client,
                                               absl::string_view kind, procgen::v1::PoolSpec spec);
// Returns "play", "replay" or "gallery" for a pool created by a page, else "pool".
std::string KindOfPool(absl::string_view name);

// A pool of one environment that a page steps. The destructor deletes the pool. Threads: one at a
// time.
class SingleEnvPool {
 public:
  // `spec` has one environment. Errors: those of the server.
  static absl::StatusOr<std::unique_ptr<SingleEnvPool>> Make(
      std::shared_ptr<procgen_client::Client> client, absl::string_view kind,
      const procgen::v1::PoolSpec& spec);
  ~SingleEnvPool();
  SingleEnvPool(const SingleEnvPool&) = delete;
  SingleEnvPool& operator=(const SingleEnvPool&) = delete;

  // The spec of the pool, with defaults filled in.
  const procgen::v1::PoolSpec& spec() const { return spec_; }

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
  SingleEnvPool(std::shared_ptr<procgen_client::Client> client, procgen::v1::Pool pool);
  absl::StatusOr<Row> Call(procgen::v1::StepPoolRequest request);
  Row RowOf() const;
  // Whether the last step ended an episode.
  bool HasEnded() const { return batch_.terminated()[0] || batch_.truncated()[0]; }
  // Begins the next episode, with an image or not, and adds its start to `row`.
  absl::Status BeginEpisode(procgen::v1::Observation observation, Row* row);

  const std::shared_ptr<procgen_client::Client> client_;
  const std::string name_;
  const procgen::v1::PoolSpec spec_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  procgen_client::Batch batch_;
};

// A view of an environment of a pool, as a PNG file. Blocks.
absl::StatusOr<std::string> DrawPng(procgen_client::Client* client, const std::string& pool,
                                    int32_t environment, int32_t size_px,
                                    procgen::v1::FrameView view);

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_SINGLE_ENV_POOL_H_
