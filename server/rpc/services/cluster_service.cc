#include "server/rpc/services/cluster_service.h"

#include <string>
#include <utility>

#include "server/rpc/grpc/refused_stream.h"
#include "server/wire/convert_node.h"

namespace procgen {
namespace {

absl::Status StoppingError() {
  return absl::UnavailableError("the server stops; ask another node");
}

}  // namespace

ClusterServiceImpl::ClusterServiceImpl(Cluster* cluster, const CallAccounting* accounting)
    : cluster_(cluster), accounting_(accounting) {}

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

grpc::ServerUnaryReactor* ClusterServiceImpl::ListNodes(grpc::CallbackServerContext* context,
                                                        const v1::ListNodesRequest* /*request*/,
                                                        v1::ListNodesResponse* response) {
  return accounting_->Answer(context, "ClusterService/ListNodes",
                             [&](const std::string& /*owner*/) {
                               *response = NodesMessageOf<v1::ListNodesResponse>(*cluster_);
                               return absl::OkStatus();
                             });
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* ClusterServiceImpl::WatchNodes(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* /*request*/) {
  absl::StatusOr<Caller> caller = accounting_->Admit(*context);
  absl::MutexLock lock(&mutex_);
  absl::Status status = ends_watches_ ? StoppingError() : caller.status();
  if (!status.ok()) {
    return new RefusedStream<grpc::ServerWriteReactor<grpc::ByteBuffer>>(
        accounting_->EndCall("ClusterService/WatchNodes", status));
  }
  // Only the reservation is kept, so the watch does not count as a call that a drain waits for.
  const std::shared_ptr<WatchNodesReactor> watch =
      WatchNodesReactor::Start(cluster_, accounting_, std::move(caller->reservation));
  std::erase_if(watches_, [](const auto& each) { return each.expired(); });
  watches_.push_back(watch);
  return watch.get();
}

}  // namespace procgen
