#ifndef SERVER_WEB_SESSION_POOL_PAUSES_H_
#define SERVER_WEB_SESSION_POOL_PAUSES_H_

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "procgen_client/client.h"
#include "server/web/json/message.h"
#include "server/web/session/pool_report.h"

namespace procgen::web {

// The pools that one page pauses. Threads: one at a time.
class PoolPauses {
 public:
  explicit PoolPauses(PausePool pause_pool) : pause_pool_(std::move(pause_pool)) {}

  // Executes a request of pool.pause, pool.step or pool.resume; `client` has the page's token.
  // Blocks. Errors: INVALID_ARGUMENT; NOT_FOUND; FAILED_PRECONDITION a step of a pool that is not
  // paused.
  absl::StatusOr<Answer> Do(const Request& request, procgen_client::Client* client);
  // Ends all pauses.
  void Clear() { pauses_.clear(); }

 private:
  absl::Status Pause(const std::string& name, procgen_client::Client* client);

  const PausePool pause_pool_;
  std::map<std::string, std::unique_ptr<PoolPause>> pauses_;  // by the name of the pool
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_POOL_PAUSES_H_
