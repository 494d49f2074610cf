#include "server/rpc/services/cluster_service.h"

#include <string>

#include "server/wire/convert_node.h"

namespace procgen {

grpc::ServerUnaryReactor* ClusterServiceImpl::ListNodes(grpc::CallbackServerContext* context,
                                                        const v1::ListNodesRequest* /*request*/,
                                                        v1::ListNodesResponse* response) {
  return accounting_->Answer(context, "ClusterService/ListNodes",
                             [&](const std::string& /*owner*/) {
                               *response = NodesMessageOf(*cluster_);
                               return absl::OkStatus();
                             });
}

}  // namespace procgen
