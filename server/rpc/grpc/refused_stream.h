#ifndef SERVER_RPC_GRPC_REFUSED_STREAM_H_
#define SERVER_RPC_GRPC_REFUSED_STREAM_H_

#include "grpcpp/support/status.h"

namespace procgen {

// A call that ends immediately with an error. `Reactor`: of gRPC, of the call's kind.
template <typename Reactor>
class RefusedStream final : public Reactor {
 public:
  explicit RefusedStream(const grpc::Status& status) { this->Finish(status); }

 private:
  void OnDone() override { delete this; }
};

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_REFUSED_STREAM_H_
