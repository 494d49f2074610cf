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
#include "procgen/v1/cluster.pb.h"
#include "procgen/v1/render.pb.h"
#include "procgen_client/call_end.h"
#include "procgen_client/credentials.h"
#include "procgen_client/grpc_error.h"

namespace procgen_client {

// A stream of what a server tells from time to time. Made by Client, which it must not outlive; the
// stream ends with this.
// Threads: Next from one at a time; Stop from any.
template <typename Response>
class Watch {
 public:
  using Begin =
      std::function<std::unique_ptr<grpc::ClientReader<Response>>(grpc::ClientContext* context)>;

  // Whether a response makes sense.
  using Validate = std::function<absl::Status(const Response& response)>;

  // `token`: empty, none. `validate`: null, any response does.
  Watch(const std::string& token, const Begin& begin, Validate validate = nullptr)
      : validate_(std::move(validate)) {
    ShowToken(token, context_.get());
    reader_ = begin(context_.get());
  }
  // Ends the stream.
  ~Watch() {
    Stop();
    while (Next().ok()) {
    }
  }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  // How it is: at first as it is now, then as it is after the next change, which is waited for.
  // Errors: the server's; CANCELLED after Stop; INTERNAL a response makes no sense;
  // DEADLINE_EXCEEDED a response is no message, and the server does not end the stream within 10 s.
  // All later calls return the same.
  absl::StatusOr<Response> Next() {
    Response response;
    if (end_.ok() && reader_->Read(&response)) {
      absl::Status status = validate_ == nullptr ? absl::OkStatus() : validate_(response);
      if (status.ok()) {
        return response;
      }
      Stop();
      reader_->Finish();
      end_ = std::move(status);
    }
    if (end_.ok()) {
      grpc::Status status;
      end_ = AwaitEnd<Response>(context_, reader_.get(), &status);
      if (end_.ok()) {
        end_ = status.ok() ? absl::UnavailableError("the server ended the stream")
                           : ToAbslStatus(status);
      }
    }
    return end_;
  }
  // Has Next return, now and from then on.
  void Stop() { context_->TryCancel(); }

 private:
  const std::shared_ptr<grpc::ClientContext> context_ = std::make_shared<grpc::ClientContext>();
  const Validate validate_;
  std::unique_ptr<grpc::ClientReader<Response>> reader_;
  absl::Status end_;  // not OK: how the stream ended
};

// Which servers there are. UNAVAILABLE when the server stops.
using NodeWatch = Watch<procgen::v1::WatchNodesResponse>;
// What environments of a pool show. ABORTED when the pool goes, UNAVAILABLE when the server drains.
using PoolWatch = Watch<procgen::v1::WatchPoolResponse>;

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_WATCH_H_
