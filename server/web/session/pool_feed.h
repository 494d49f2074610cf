#ifndef SERVER_WEB_SESSION_POOL_FEED_H_
#define SERVER_WEB_SESSION_POOL_FEED_H_

#include <cstddef>
#include <cstdint>
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
#include "server/web/session/pool_report.h"

namespace procgen::web {

// Sends pages the state of their owners' pools every second, and records the history of all pools,
// also without followers. Has one thread. Threads: any method from any thread.
class PoolFeed {
 public:
  // Receives an event, or the error after which there are no more. Must not block.
  using OnEvent = std::function<void(const absl::StatusOr<Json>& event)>;

  // `report_pools` returns the pools of all owners. Followers receive only those of their owner.
  explicit PoolFeed(std::function<std::vector<PoolReport>()> report_pools);
  ~PoolFeed();
  PoolFeed(const PoolFeed&) = delete;
  PoolFeed& operator=(const PoolFeed&) = delete;

  // Starts at once. Followers with the same token share one set of calls to the server; `client`
  // presents that token. After an error `on_event` is not called again.
  void Follow(const void* follower, const std::string& token,
              std::shared_ptr<procgen_client::Client> client, OnEvent on_event);
  // `on_event` is not called after the return.
  void Unfollow(const void* follower);

  // History of a pool, as PoolHistory::RowsOf; `pool` is the owner's view, from GetPool.
  Json HistoryOf(const procgen::v1::Pool& pool, int32_t span_s);
  // Mean returns of a pool, as PoolHistory::ReturnsOf.
  Json ReturnsOf(const procgen::v1::Pool& pool, size_t count);

 private:
  struct Follower {
    std::string token;
    std::shared_ptr<procgen_client::Client> client;
    OnEvent on_event;
    bool is_new = true;
  };

  void Run();
  // Notifies all followers, or only new ones.
  void TellFollowers(bool only_new, const std::vector<PoolReport>& all_pools);
  absl::StatusOr<Json> EventFor(procgen_client::Client* client,
                                const std::vector<PoolReport>& all_pools);

  const std::function<std::vector<PoolReport>()> report_pools_;
  // Lock order: notify_mutex_, mutex_.
  absl::Mutex notify_mutex_;  // held while followers are notified
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
