#ifndef SERVER_WEB_SESSION_POOL_FEED_H_
#define SERVER_WEB_SESSION_POOL_FEED_H_

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "procgen_client/client.h"
#include "server/concurrency/steady_time.h"
#include "server/web/json/message.h"
#include "server/web/session/pool_history.h"

namespace procgen::web {

// Tells pages once a second how the pools of their owners stand, and keeps how all went, also
// while nobody looks. One thread of its own. Threads: any method from any thread.
class PoolFeed {
 public:
  // What a follower gets: the event, or why there will be no more. Must not block.
  using Tell = std::function<void(const absl::StatusOr<Json>& event)>;

  // `list_pools` tells all pools, whoever owns them; nobody is shown those of others.
  explicit PoolFeed(std::function<std::vector<procgen::v1::Pool>()> list_pools);
  ~PoolFeed();
  PoolFeed(const PoolFeed&) = delete;
  PoolFeed& operator=(const PoolFeed&) = delete;

  // Begins at once. Followers with the same token share what is asked of the server; `client` shows
  // that token. A follower that was told of an error is told nothing more.
  void Follow(const void* follower, const std::string& token,
              std::shared_ptr<procgen_client::Client> client, Tell tell);
  // `tell` is not called after.
  void Unfollow(const void* follower);

  // How a pool went; `pool` is as its owner was shown it.
  Json HistoryOf(const procgen::v1::Pool& pool);

 private:
  struct Follower {
    std::string token;
    std::shared_ptr<procgen_client::Client> client;
    Tell tell;
    bool is_new = true;
  };

  void Run();
  // Tells all followers, or the new ones.
  void TellFollowers(bool only_new);
  absl::StatusOr<Json> EventFor(procgen_client::Client* client);

  const std::function<std::vector<procgen::v1::Pool>()> list_pools_;
  // Lock order: telling_, mutex_.
  absl::Mutex telling_;  // while followers are told
  absl::Mutex mutex_;
  SteadyCondVar changed_;  // has_new_, or is_stopping_
  PoolHistory history_ ABSL_GUARDED_BY(mutex_);
  std::map<const void*, Follower> followers_ ABSL_GUARDED_BY(mutex_);
  bool has_new_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_POOL_FEED_H_
