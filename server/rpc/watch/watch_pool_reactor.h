#ifndef SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_
#define SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_

#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/watch/latest_stream.h"
#include "server/session/pool_supervisor.h"
#include "server/session/quota/quotas.h"
#include "server/session/watch/frame_subscriber.h"

namespace procgen {

// One stream of WatchPool: reads the request, then sends frame sets of its pool.
// Threads: any method from any thread.
class WatchPoolReactor final : public LatestStream, public FrameSubscriber {
 public:
  // Starts a stream, which lives at least until OnDone. The pointers must outlive it. `caller` is
  // held until the request has arrived, because a drain does not wait for watches.
  static WatchPoolReactor* Start(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                 Caller caller);
  ~WatchPoolReactor() override = default;

  bool IsReady() override { return IsIdle(); }
  void Take(const absl::Cord& frame_set) override;
  // Ends the stream after the current write. No effect if it has ended.
  void End(const absl::Status& reason) override;

 private:
  WatchPoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting, Caller caller);

  void OnRequest(absl::StatusOr<grpc::ByteBuffer> request) override;
  absl::Status Watch(const Caller& caller, const grpc::ByteBuffer& request);
  void ReleaseSource() override;

  PoolSupervisor* const supervisor_;
  Caller caller_;  // until the request has arrived
  Quotas::Reservation reservation_;
  std::weak_ptr<WatchPoolReactor> weak_self_;
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_
