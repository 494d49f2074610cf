#ifndef SERVER_RPC_GRPC_METHOD_NAME_H_
#define SERVER_RPC_GRPC_METHOD_NAME_H_

#include <string>

#include "google/protobuf/descriptor.h"

namespace procgen {

// Returns the name of the API method that takes `request`, "SERVICE/METHOD". REQUIRES: a service in
// the same file has such a method.
std::string MethodNameOf(const google::protobuf::Descriptor& request);

// The same with the package, "package.SERVICE/METHOD".
std::string FullMethodNameOf(const google::protobuf::Descriptor& request);

// The same, computed once per type.
template <typename Request>
const std::string& MethodNameOf() {
  static const std::string* const name = new std::string(MethodNameOf(*Request::descriptor()));
  return *name;
}

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_METHOD_NAME_H_
