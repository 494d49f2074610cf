#ifndef SERVER_RPC_SERVICES_REFLECTION_SERVICE_H_
#define SERVER_RPC_SERVICES_REFLECTION_SERVICE_H_

#include <set>
#include <string>

#include "google/protobuf/descriptor_database.h"
#include "grpc/reflection/v1/reflection.pb.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"

namespace procgen {

// grpc.reflection.v1.ServerReflection, and the same as v1alpha: lists the services and their
// descriptor files. gRPC's own implementation is not used because it needs a thread per stream.
// Threads: any method from any thread.
class ReflectionServiceImpl final : public ByteService {
 public:
  using Request = grpc::reflection::v1::ServerReflectionRequest;
  using Response = grpc::reflection::v1::ServerReflectionResponse;

  // `services`: names of the services to list, besides health and reflection. `accounting` must
  // outlive this.
  ReflectionServiceImpl(const CallAccounting* accounting, std::set<std::string> services);

  // Returns the response to a request. It contains an error if the requested item does not exist.
  Response Answer(const Request& request);

 private:
  // Adds a file and its imports.
  void AddFile(const google::protobuf::FileDescriptor& file);
  void AnswerFile(const google::protobuf::FileDescriptorProto& file, Response* response);
  ByteStream* BeginInfo(grpc::CallbackServerContext* context);

  const CallAccounting* const accounting_;
  std::set<std::string> services_;
  google::protobuf::SimpleDescriptorDatabase files_;  // only read after construction
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_REFLECTION_SERVICE_H_
