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

// One stream of WatchPool: reads which pool is to be watched, then sends frame sets of it.
// Threads: any method from any thread.
class WatchPoolReactor final : public LatestStream, public FrameSubscriber {
 public:
  // Begins a stream, which lives until gRPC has done with it, and longer if somebody holds it. What
  // is pointed to must outlive it. `caller` counts until the request has arrived: a drain does not
  // wait for those who watch.
  static WatchPoolReactor* Start(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                 Caller caller);
  ~WatchPoolReactor() override = default;

  bool IsReady() override { return IsIdle(); }
  void Take(const absl::Cord& frame_set) override;
  // Ends the stream, once what is being sent is on its way, unless it has ended.
  void End(const absl::Status& reason) override;

 private:
  WatchPoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting, Caller caller);

  void OnRequest(absl::StatusOr<grpc::ByteBuffer> request) override;
  absl::Status Watch(const Caller& caller, const grpc::ByteBuffer& request);
  void ReleaseSource() override;

  PoolSupervisor* const supervisor_;
  Caller caller_;  // until the request is there
  Quotas::Reservation reservation_;
  std::weak_ptr<WatchPoolReactor> weak_self_;
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_
