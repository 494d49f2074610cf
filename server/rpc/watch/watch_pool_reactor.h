#ifndef SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_
#define SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_

#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "server/pool/pool_supervisor.h"
#include "server/pool/quota/quotas.h"
#include "server/pool/watch/frame_publishers.h"
#include "server/pool/watch/frame_subscriber.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/watch/latest_stream.h"
#include "server/wire/convert_frames.h"

namespace procgen {

// One stream of WatchPool: sends frame sets of its pool.
// Threads: any method from any thread.
class WatchPoolReactor final : public LatestStream, public FrameSubscriber {
 public:
  // Starts a stream, which lives at least until OnDone. The pointers must outlive it.
  static WatchPoolReactor* Start(PoolSupervisor* supervisor, FramePublishers* publishers,
                                 const CallAccounting* accounting, Caller caller,
                                 const grpc::ByteBuffer& request);
  ~WatchPoolReactor() override = default;

  bool IsReady() override { return IsIdle(); }
  void Take(const absl::Cord& frame_set) override;
  // Ends the stream after the current write. No effect if it has ended.
  void End(const absl::Status& reason) override;

 private:
  WatchPoolReactor(PoolSupervisor* supervisor, FramePublishers* publishers,
                   const CallAccounting* accounting, Quotas::Reservation reservation);

  static absl::Status Watch(const std::shared_ptr<WatchPoolReactor>& self, const std::string& owner,
                            const grpc::ByteBuffer& request);
  void ReleaseSource() override;

  PoolSupervisor* const supervisor_;
  FramePublishers* const publishers_;
  // Set before the first frame set if the request asks for it. Used when a response is sent, so by
  // one thread at a time.
  std::optional<DeltaFrameEncoder> delta_encoder_;
  Quotas::Reservation delta_memory_;
  // Without Caller::under_way, because a drain does not wait for watches.
  Quotas::Reservation reservation_;
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_
