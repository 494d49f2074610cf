#ifndef SERVER_RPC_REFUSED_STREAM_H_
#define SERVER_RPC_REFUSED_STREAM_H_

#include "absl/status/status.h"
#include "server/rpc/grpc_status.h"

namespace procgen {

// A stream that ends with an error at once. Reactor: the kind that the method answers with.
template <typename Reactor>
class RefusedStream final : public Reactor {
 public:
  explicit RefusedStream(const absl::Status& status) { this->Finish(ToGrpcStatus(status)); }

 private:
  void OnDone() override { delete this; }
};

}  // namespace procgen

#endif  // SERVER_RPC_REFUSED_STREAM_H_
