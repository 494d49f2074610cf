#ifndef PROCGEN_CLIENT_WATCH_H_
#define PROCGEN_CLIENT_WATCH_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "procgen/v1/pool_service.grpc.pb.h"
#include "procgen_client/credentials.h"
#include "procgen_client/internal/grpc_error.h"

namespace procgen_client {

// Frames of a pool (WatchPool), now and after each change. Created by Client. Destroying it ends
// the stream. Ends with ABORTED when the pool ends, and with UNAVAILABLE when the server drains.
// Threads: Next from one thread at a time; Stop from any.
class PoolWatch {
 public:
  // `token`: empty for none.
  PoolWatch(const std::shared_ptr<grpc::Channel>& channel, const std::string& token,
            const procgen::v1::WatchPoolRequest& request) {
    ShowToken(token, &context_);
    reader_ = procgen::v1::PoolService::NewStub(channel)->WatchPool(&context_, request);
  }
  // Ends the stream.
  ~PoolWatch() {
    Stop();
    while (Next().ok()) {
    }
  }
  PoolWatch(const PoolWatch&) = delete;
  PoolWatch& operator=(const PoolWatch&) = delete;

  // Returns the current value on the first call; later calls block until the next change. Errors:
  // those of the server; CANCELLED after Stop. After an error all calls return it.
  absl::StatusOr<procgen::v1::WatchPoolResponse> Next() {
    procgen::v1::WatchPoolResponse response;
    if (end_.ok() && reader_->Read(&response)) {
      return response;
    }
    if (end_.ok()) {
      const grpc::Status status = reader_->Finish();
      end_ = status.ok() ? absl::UnavailableError("the server ended the stream")
                         : ToAbslStatus(status);
    }
    return end_;
  }
  // Makes Next return CANCELLED, also one that is blocked.
  void Stop() { context_.TryCancel(); }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<procgen::v1::WatchPoolResponse>> reader_;
  absl::Status end_;  // OK while the stream is open
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_WATCH_H_
