#ifndef SERVER_RPC_WATCH_POOL_REACTOR_H_
#define SERVER_RPC_WATCH_POOL_REACTOR_H_

#include <memory>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "server/rpc/caller.h"
#include "server/rpc/latest_stream.h"
#include "server/session/owners.h"
#include "server/session/pool_views.h"
#include "server/session/watcher.h"

namespace procgen {

// One stream of WatchPool: sends moments of a pool. Threads: any method from any thread.
class WatchPoolReactor final : public LatestStream, public Watcher {
 public:
  // Begins a stream, which lives until gRPC has done with it, and longer if somebody holds it.
  // `share`: of what the owner may watch. `views` and `callers` must outlive it.
  static WatchPoolReactor* Start(PoolViews* views, const Callers* callers,
                                 std::shared_ptr<PoolSession> pool, const WatchOrder& order,
                                 const EncodeMoment& encode, Owners::Share share);
  ~WatchPoolReactor() override = default;

  bool IsReady() override { return IsIdle(); }
  void Take(const absl::Cord& moment) override;
  // Ends the stream, once what is being sent is on its way, unless it has ended.
  void End(const absl::Status& reason) override;

 private:
  WatchPoolReactor(PoolViews* views, const Callers* callers, Owners::Share share);

  void LetGo() override;

  PoolViews* const views_;
  Owners::Share share_;
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_POOL_REACTOR_H_
