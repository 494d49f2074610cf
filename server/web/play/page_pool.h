#ifndef SERVER_WEB_PLAY_PAGE_POOL_H_
#define SERVER_WEB_PLAY_PAGE_POOL_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "procgen/v1/run.pb.h"
#include "procgen_client/client.h"

namespace procgen::web {

// Returns "play", "replay" or "gallery" for a pool of a page, else "pool".
std::string KindOfPool(absl::string_view name);

// A pool of a page, named "pools/web-KIND-...", which lives as long as this. Methods block. After
// an error every later call returns it. Threads: one at a time.
class PagePool {
 public:
  // Requests that may be sent ahead.
  static constexpr int kAheadMax = 8;

  // Errors: those of the server.
  static absl::StatusOr<std::unique_ptr<PagePool>> Start(
      std::shared_ptr<procgen_client::Client> client, absl::string_view kind,
      const procgen::v1::PoolSpec& spec);

  // The spec of the pool, with defaults filled in.
  const procgen::v1::PoolSpec& spec() const { return spec_; }

  // Sends a request and returns the response. REQUIRES: no request is unanswered.
  absl::StatusOr<procgen::v1::RunPoolResponse> Call(const procgen::v1::RunPoolRequest& request);
  // The two halves of Call. REQUIRES: fewer than kAheadMax requests are unanswered; one is.
  absl::Status Send(const procgen::v1::RunPoolRequest& request);
  absl::StatusOr<procgen::v1::RunPoolResponse> Receive();

  // A view of an environment, as a PNG file.
  absl::StatusOr<std::string> Draw(int32_t environment, int32_t size_px,
                                   procgen::v1::FrameView view);

 private:
  explicit PagePool(std::shared_ptr<procgen_client::Client> client);

  // Handles the next event of the stream.
  absl::Status Advance();

  const std::shared_ptr<procgen_client::Client> client_;
  const std::unique_ptr<procgen_client::RunStream> stream_;
  std::deque<procgen::v1::RunPoolResponse> received_;
  bool is_writing_ = false;
  procgen::v1::PoolSpec spec_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_PAGE_POOL_H_
