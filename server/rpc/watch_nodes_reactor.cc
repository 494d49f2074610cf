#include "server/rpc/watch_nodes_reactor.h"

#include <utility>

#include "grpcpp/impl/codegen/proto_utils.h"
#include "procgen/v1/cluster.pb.h"
#include "server/rpc/convert_node.h"
#include "server/rpc/method_name.h"

namespace procgen {

std::shared_ptr<WatchNodesReactor> WatchNodesReactor::Start(Cluster* cluster,
                                                            const Callers* callers,
                                                            Owners::Share share) {
  std::shared_ptr<WatchNodesReactor> reactor(
      new WatchNodesReactor(cluster, callers, std::move(share)));
  reactor->self_ = reactor;
  reactor->subscription_ = cluster->Subscribe([it = reactor.get()] { it->NoteChange(); });
  reactor->Continue();
  return reactor;
}

WatchNodesReactor::WatchNodesReactor(Cluster* cluster, const Callers* callers, Owners::Share share)
    : cluster_(cluster), callers_(callers), share_(std::move(share)) {}

void WatchNodesReactor::End(const absl::Status& status) {
  {
    absl::MutexLock lock(&mutex_);
    if (std::exchange(ends_, true)) {
      return;
    }
    status_ = status;
  }
  Continue();
}

void WatchNodesReactor::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    writes_ = false;
  }
  if (ok) {
    Continue();
  } else {
    End(absl::OkStatus());  // who watched has gone
  }
}

void WatchNodesReactor::OnCancel() { End(absl::OkStatus()); }

void WatchNodesReactor::OnDone() {
  subscription_ = Subscription();
  const std::shared_ptr<WatchNodesReactor> self = std::move(self_);
}

void WatchNodesReactor::NoteChange() {
  {
    absl::MutexLock lock(&mutex_);
    has_changed_ = true;
  }
  Continue();
}

void WatchNodesReactor::Continue() {
  absl::Status status;
  bool ends = false;
  {
    absl::MutexLock lock(&mutex_);
    if (writes_ || ended_ || !(ends_ || has_changed_)) {
      return;
    }
    ends = ends_;
    status = status_;
    ended_ = ends;
    writes_ = !ends;
    has_changed_ = false;
  }
  if (ends) {
    Finish(callers_->Dismiss(MethodNameOf<v1::WatchNodesRequest>(), status));
    return;
  }
  response_.Clear();
  bool own_buffer = false;
  grpc::SerializationTraits<v1::WatchNodesResponse>::Serialize(
      NodesMessageOf<v1::WatchNodesResponse>(*cluster_), &response_, &own_buffer);
  StartWrite(&response_);
}

}  // namespace procgen
