#ifndef SERVER_RPC_CALL_BYTE_SERVICE_H_
#define SERVER_RPC_CALL_BYTE_SERVICE_H_

#include <functional>
#include <list>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"
#include "grpcpp/impl/service_type.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/grpc/method_name.h"

namespace procgen {

// A call as a bidirectional stream of raw bytes, which the server parses and serialises.
using ByteStream = grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>;

// A gRPC service whose methods are called when the headers of a call have arrived. gRPC collects
// the whole request of a unary or server streaming method before it calls the method, so a caller
// without a token could hold request_bytes_max for each call indefinitely. All methods
// are therefore registered as bidirectional streams, which are the same on the wire.
class ByteService : public grpc::Service {
 public:
  // Creates the reactor of a call.
  using Begin = std::function<ByteStream*(grpc::CallbackServerContext*)>;

  // Name of the service, "package.Service".
  std::string service_name() const;

 protected:
  // Registers `begin` for a method, "package.Service/Method".
  void AddByteMethod(absl::string_view method, Begin begin);
  // Registers `begin` for the method that takes `Request`.
  template <typename Request>
  void AddByteMethod(Begin begin) {
    AddByteMethod(FullMethodNameOf(*Request::descriptor()), std::move(begin));
  }

 private:
  std::list<std::string> names_;  // of methods; gRPC keeps pointers to them
  int method_count_ = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_BYTE_SERVICE_H_
