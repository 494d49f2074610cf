#include "procgen_client/node_watch.h"

#include "procgen_client/credentials.h"
#include "procgen_client/grpc_error.h"

namespace procgen_client {

namespace v1 = procgen::v1;

NodeWatch::NodeWatch(v1::ClusterService::Stub* stub, const std::string& token) {
  ShowToken(token, &context_);
  reader_ = stub->WatchNodes(&context_, v1::WatchNodesRequest());
}

NodeWatch::~NodeWatch() {
  Stop();
  while (Next().ok()) {
  }
}

absl::StatusOr<v1::WatchNodesResponse> NodeWatch::Next() {
  v1::WatchNodesResponse response;
  if (end_.ok() && reader_->Read(&response)) {
    return response;
  }
  if (end_.ok()) {
    const grpc::Status status = reader_->Finish();
    end_ =
        status.ok() ? absl::UnavailableError("the server ended the stream") : ToAbslStatus(status);
  }
  return end_;
}

void NodeWatch::Stop() { context_.TryCancel(); }

}  // namespace procgen_client
