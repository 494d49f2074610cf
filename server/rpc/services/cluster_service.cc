#include "server/rpc/services/cluster_service.h"

#include <utility>

#include "server/rpc/call/refused_stream.h"
#include "server/rpc/call/unary_call.h"
#include "server/rpc/grpc/method_name.h"
#include "server/wire/convert_node.h"

namespace procgen {
namespace {

absl::Status StoppingError() {
  return absl::UnavailableError("the server stops; ask another node");
}

}  // namespace

ClusterServiceImpl::ClusterServiceImpl(Cluster* cluster, const CallAccounting* accounting)
    : cluster_(cluster), accounting_(accounting) {
  AddByteMethod<v1::ListNodesRequest>([this](auto* context) { return ListNodes(context); });
  AddByteMethod<v1::WatchNodesRequest>([this](auto* context) { return WatchNodes(context); });
}

void ClusterServiceImpl::EndWatches() {
  std::vector<std::weak_ptr<WatchNodesReactor>> watches;
  {
    absl::MutexLock lock(&mutex_);
    ends_watches_ = true;
    watches = std::move(watches_);
    watches_.clear();
  }
  for (const std::weak_ptr<WatchNodesReactor>& each : watches) {
    if (const std::shared_ptr<WatchNodesReactor> watch = each.lock(); watch != nullptr) {
      watch->Close(StoppingError());
    }
  }
}

ByteStream* ClusterServiceImpl::ListNodes(grpc::CallbackServerContext* context) {
  using Call = UnaryCall<v1::ListNodesRequest, v1::ListNodesResponse>;
  return Call::Start(*accounting_, *context, [this](Call* call) {
    *call->response() = NodesMessageOf<v1::ListNodesResponse>(*cluster_);
    call->Finish(absl::OkStatus());
  });
}

ByteStream* ClusterServiceImpl::WatchNodes(grpc::CallbackServerContext* context) {
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  absl::MutexLock lock(&mutex_);
  absl::Status status = ends_watches_ ? StoppingError() : caller.status();
  if (!status.ok()) {
    return new RefusedStream(accounting_->EndCall(MethodNameOf<v1::WatchNodesRequest>(), status));
  }
  // Only the reservation is kept, so the watch does not count as a call that a drain waits for.
  const std::shared_ptr<WatchNodesReactor> watch =
      WatchNodesReactor::Start(cluster_, accounting_, std::move(caller->reservation));
  std::erase_if(watches_, [](const auto& each) { return each.expired(); });
  watches_.push_back(watch);
  return watch.get();
}

}  // namespace procgen
