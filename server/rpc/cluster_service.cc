#include "server/rpc/cluster_service.h"

#include <utility>

#include "server/rpc/convert_node.h"
#include "server/rpc/method_name.h"
#include "server/rpc/refused_stream.h"
#include "server/rpc/unary_call.h"

namespace procgen {
namespace {

absl::Status StopsError() { return absl::UnavailableError("the server stops; ask another node"); }

}  // namespace

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
      watch->Close(StopsError());
    }
  }
}

grpc::ServerUnaryReactor* ClusterServiceImpl::ListNodes(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request,
                                                        grpc::ByteBuffer* response) {
  using Call = UnaryCall<v1::ListNodesRequest, v1::ListNodesResponse>;
  return Call::Start(*callers_, *context, request, response, [this](Call* call) {
    *call->response() = NodesMessageOf<v1::ListNodesResponse>(*cluster_);
    call->Finish(absl::OkStatus());
  });
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* ClusterServiceImpl::WatchNodes(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  v1::WatchNodesRequest message;
  absl::StatusOr<Caller> caller = callers_->Admit(*context);
  absl::Status status = caller.status();
  if (status.ok()) {
    status = ParseMessage(*request, &message);
  }
  absl::MutexLock lock(&mutex_);
  if (status.ok() && ends_watches_) {
    status = StopsError();
  }
  if (!status.ok()) {
    return new RefusedStream<grpc::ServerWriteReactor<grpc::ByteBuffer>>(
        callers_->Dismiss(MethodNameOf<v1::WatchNodesRequest>(), status));
  }
  // What else the caller counts in is left: a drain does not wait for those who watch.
  const std::shared_ptr<WatchNodesReactor> watch =
      WatchNodesReactor::Start(cluster_, callers_, std::move(caller->share));
  std::erase_if(watches_, [](const auto& each) { return each.expired(); });
  watches_.push_back(watch);
  return watch.get();
}

}  // namespace procgen
