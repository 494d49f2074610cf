#ifndef SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_
#define SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_

#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/pool/pool_supervisor.h"
#include "server/pool/quota/quotas.h"
#include "server/pool/watch/frame_publishers.h"
#include "server/pool/watch/frame_subscriber.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/wire/convert_frames.h"

namespace procgen {

// One stream of WatchPool: sends the latest frame set of its pool, one response at a time. While
// one is being sent, the latest waits and replaces earlier ones, so a client that does not read
// costs two responses.
// Threads: any method from any thread.
class WatchPoolReactor final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                               public FrameSubscriber {
 public:
  // Starts a stream, which lives at least until OnDone. The pointers must outlive it.
  static WatchPoolReactor* Start(PoolSupervisor* supervisor, FramePublishers* publishers,
                                 const CallAccounting* accounting, Caller caller,
                                 const grpc::ByteBuffer& request);
  ~WatchPoolReactor() override = default;

  // Whether a response would be sent immediately.
  bool IsReady() override ABSL_LOCKS_EXCLUDED(mutex_);
  // Sends a frame set, or replaces the waiting one.
  void Take(const absl::Cord& frame_set) override ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends the stream after the current write. No effect if it has ended.
  void End(const absl::Status& reason) override ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  WatchPoolReactor(PoolSupervisor* supervisor, FramePublishers* publishers,
                   const CallAccounting* accounting, Quotas::Reservation reservation);

  static absl::Status Watch(const std::shared_ptr<WatchPoolReactor>& self, const std::string& owner,
                            const grpc::ByteBuffer& request);
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  // Writes the waiting frame set or ends the stream, unless a write is in progress. Calls gRPC
  // without the lock, because it may call back immediately.
  void Continue() ABSL_LOCKS_EXCLUDED(mutex_);
  grpc::ByteBuffer ResponseOf(const absl::Cord& frame_set);

  PoolSupervisor* const supervisor_;
  FramePublishers* const publishers_;
  const CallAccounting* const accounting_;
  std::shared_ptr<WatchPoolReactor> self_;  // until OnDone
  // Set before the first frame set if the request asks for it. Used when a response is sent, so by
  // one thread at a time.
  std::optional<DeltaFrameEncoder> delta_encoder_;
  Quotas::Reservation delta_memory_;
  // Without Caller::under_way, because a drain does not wait for watches.
  Quotas::Reservation reservation_;
  grpc::ByteBuffer written_;  // by the current write

  absl::Mutex mutex_;
  std::optional<absl::Cord> waiting_ ABSL_GUARDED_BY(mutex_);
  bool writes_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);  // final status; set by End
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_WATCH_POOL_REACTOR_H_
