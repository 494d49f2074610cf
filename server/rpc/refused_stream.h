#ifndef SERVER_RPC_REFUSED_STREAM_H_
#define SERVER_RPC_REFUSED_STREAM_H_

#include "grpcpp/support/status.h"

namespace procgen {

// A stream that ends with an error at once. Reactor: the kind that the method answers with.
template <typename Reactor>
class RefusedStream final : public Reactor {
 public:
  explicit RefusedStream(const grpc::Status& status) { this->Finish(status); }

 private:
  void OnDone() override { delete this; }
};

}  // namespace procgen

#endif  // SERVER_RPC_REFUSED_STREAM_H_
