#ifndef SERVER_WEB_SESSION_POOL_PAUSES_H_
#define SERVER_WEB_SESSION_POOL_PAUSES_H_

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "procgen_client/client.h"
#include "server/web/json/message.h"
#include "server/web/session/pool_report.h"

namespace procgen::web {

// The pools that one page pauses. Threads: End from any thread, the others one at a time.
class PoolPauses {
 public:
  explicit PoolPauses(PausePool pause_pool) : pause_pool_(std::move(pause_pool)) {}

  // Executes a request of pool.pause, pool.step or pool.resume; `client` has the page's token.
  // Blocks. Errors: INVALID_ARGUMENT; NOT_FOUND; FAILED_PRECONDITION a step of a pool that is not
  // paused, or a pause of a pool that a page steps: the page's only thread would wait for itself.
  absl::StatusOr<Answer> Do(const Request& request, procgen_client::Client* client)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends all pauses. No pause begins afterwards.
  void End() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  absl::Status Pause(const std::string& name, procgen_client::Client* client)
      ABSL_LOCKS_EXCLUDED(mutex_);

  const PausePool pause_pool_;
  absl::Mutex mutex_;
  bool has_ended_ ABSL_GUARDED_BY(mutex_) = false;
  // By the name of the pool.
  std::map<std::string, std::unique_ptr<PoolPause>> pauses_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_POOL_PAUSES_H_
