#ifndef SERVER_RPC_WATCH_NODES_REACTOR_H_
#define SERVER_RPC_WATCH_NODES_REACTOR_H_

#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/cluster/cluster.h"
#include "server/rpc/caller.h"

namespace procgen {

// One stream of WatchNodes: sends the nodes, and again when they have changed and what was sent
// before is on its way. So a client that does not read costs one response.
// Threads: any method from any thread.
class WatchNodesReactor final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  // Begins a stream, which lives until gRPC has done with it, and longer if somebody holds it.
  // `share`: of the owner's calls; the stream is one of them while it lasts. `cluster` and
  // `callers` must outlive it.
  static std::shared_ptr<WatchNodesReactor> Start(Cluster* cluster, const Callers* callers,
                                                  Owners::Share share);
  ~WatchNodesReactor() override = default;

  // Ends the stream, once what is being sent is on its way, unless it has ended.
  void End(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  WatchNodesReactor(Cluster* cluster, const Callers* callers, Owners::Share share);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void NoteChange() ABSL_LOCKS_EXCLUDED(mutex_);
  // Writes, or ends, if there is reason to and no write is under way. gRPC is called without the
  // lock, since it may call back at once.
  void Continue() ABSL_LOCKS_EXCLUDED(mutex_);

  Cluster* const cluster_;
  const Callers* const callers_;
  const Owners::Share share_;
  std::shared_ptr<WatchNodesReactor> self_;  // until gRPC has done with it
  grpc::ByteBuffer response_;                // of the write under way

  absl::Mutex mutex_;
  bool has_changed_ ABSL_GUARDED_BY(mutex_) = true;
  bool writes_ ABSL_GUARDED_BY(mutex_) = false;
  bool ends_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);  // that it ends with

  Subscription subscription_;
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_NODES_REACTOR_H_
