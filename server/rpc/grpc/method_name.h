#ifndef SERVER_RPC_GRPC_METHOD_NAME_H_
#define SERVER_RPC_GRPC_METHOD_NAME_H_

#include <string>

#include "google/protobuf/descriptor.h"

namespace procgen {

// The method of the contract that takes `request`, "SERVICE/METHOD". REQUIRES: one of its file
// does.
std::string MethodNameOf(const google::protobuf::Descriptor& request);

// As above with the package, "package.SERVICE/METHOD".
std::string FullMethodNameOf(const google::protobuf::Descriptor& request);

// As above; made once.
template <typename Request>
const std::string& MethodNameOf() {
  static const std::string* const name = new std::string(MethodNameOf(*Request::descriptor()));
  return *name;
}

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_METHOD_NAME_H_
