#ifndef PROCGEN_CLIENT_WATCH_H_
#define PROCGEN_CLIENT_WATCH_H_

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "procgen/v1/render.pb.h"
#include "procgen_client/credentials.h"
#include "procgen_client/internal/grpc_error.h"

namespace procgen_client {

// A server stream that returns a value now and after each change. Created by Client, which must
// outlive it. Destroying it ends the stream.
// Threads: Next from one thread at a time; Stop from any.
template <typename Response>
class Watch {
 public:
  using Begin =
      std::function<std::unique_ptr<grpc::ClientReader<Response>>(grpc::ClientContext* context)>;

  // `token`: empty for none.
  Watch(const std::string& token, const Begin& begin) {
    ShowToken(token, &context_);
    reader_ = begin(&context_);
  }
  // Ends the stream.
  ~Watch() {
    Stop();
    while (Next().ok()) {
    }
  }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  // Returns the current value on the first call; later calls block until the next change. Errors:
  // those of the server; CANCELLED after Stop. After an error all calls return it.
  absl::StatusOr<Response> Next() {
    Response response;
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
  std::unique_ptr<grpc::ClientReader<Response>> reader_;
  absl::Status end_;  // OK while the stream is open
};

// Frames of a pool (WatchPool). Ends with ABORTED when the pool ends,
// and with UNAVAILABLE when the server drains.
using PoolWatch = Watch<procgen::v1::WatchPoolResponse>;

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_WATCH_H_
