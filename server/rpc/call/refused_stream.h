#ifndef SERVER_RPC_CALL_REFUSED_STREAM_H_
#define SERVER_RPC_CALL_REFUSED_STREAM_H_

#include "grpcpp/support/status.h"
#include "server/rpc/call/byte_service.h"

namespace procgen {

// A call that ends immediately with an error.
class RefusedStream final : public ByteStream {
 public:
  explicit RefusedStream(const grpc::Status& status) { Finish(status); }

 private:
  void OnDone() override { delete this; }
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_REFUSED_STREAM_H_
