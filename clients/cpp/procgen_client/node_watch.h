#ifndef PROCGEN_CLIENT_NODE_WATCH_H_
#define PROCGEN_CLIENT_NODE_WATCH_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "procgen/v1/cluster.grpc.pb.h"

namespace procgen_client {

// Tells which servers there are, and again when that changes. Made by Client::WatchNodes, which it
// must not outlive; the stream ends with this.
// Threads: Next from one at a time; Stop from any.
class NodeWatch {
 public:
  // `token`: empty, none.
  NodeWatch(procgen::v1::ClusterService::Stub* stub, const std::string& token);
  // Ends the stream.
  ~NodeWatch();
  NodeWatch(const NodeWatch&) = delete;
  NodeWatch& operator=(const NodeWatch&) = delete;

  // The servers: at first as they are now, then as they are after the next change, which is waited
  // for. Errors: the server's, UNAVAILABLE when it stops; CANCELLED after Stop. All later calls
  // return the same.
  absl::StatusOr<procgen::v1::WatchNodesResponse> Next();
  // Has Next return, now and from then on.
  void Stop();

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<procgen::v1::WatchNodesResponse>> reader_;
  absl::Status end_;  // not OK: how the stream ended
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_NODE_WATCH_H_
