#ifndef SERVER_RPC_WATCH_POOL_REACTOR_H_
#define SERVER_RPC_WATCH_POOL_REACTOR_H_

#include <memory>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/caller.h"
#include "server/session/owners.h"
#include "server/session/pool_views.h"
#include "server/session/watcher.h"

namespace procgen {

// One stream of WatchPool: sends moments of a pool, one at a time. While one is on its way the
// latest waits, and those before it are left out. So a client that does not read costs two
// responses. Threads: any method from any thread.
class WatchPoolReactor final : public grpc::ServerWriteReactor<grpc::ByteBuffer>, public Watcher {
 public:
  // Begins a stream, which lives until gRPC has done with it, and longer if somebody holds it.
  // `share`: of what the owner may watch. `views` and `callers` must outlive it.
  static WatchPoolReactor* Start(PoolViews* views, const Callers* callers,
                                 std::shared_ptr<PoolSession> pool, const WatchOrder& order,
                                 const EncodeMoment& encode, Owners::Share share);
  ~WatchPoolReactor() override = default;

  bool IsReady() override ABSL_LOCKS_EXCLUDED(mutex_);
  void Take(const absl::Cord& moment) override ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends the stream, once what is being sent is on its way, unless it has ended.
  void End(const absl::Status& reason) override ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  WatchPoolReactor(PoolViews* views, const Callers* callers, Owners::Share share);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  // Writes, or ends, if there is reason to and no write is under way. gRPC is called without the
  // lock, since it may call back at once.
  void Continue() ABSL_LOCKS_EXCLUDED(mutex_);

  PoolViews* const views_;
  const Callers* const callers_;
  Owners::Share share_;
  std::shared_ptr<WatchPoolReactor> self_;  // until gRPC has done with it
  grpc::ByteBuffer response_;               // of the write under way

  absl::Mutex mutex_;
  std::optional<absl::Cord> waiting_ ABSL_GUARDED_BY(mutex_);  // the latest moment
  bool writes_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);  // that it is to end with
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_POOL_REACTOR_H_
