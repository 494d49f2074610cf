#ifndef SERVER_RPC_SERVICES_REFLECTION_SERVICE_H_
#define SERVER_RPC_SERVICES_REFLECTION_SERVICE_H_

#include <set>
#include <string>

#include "google/protobuf/descriptor_database.h"
#include "grpc/reflection/v1/reflection.pb.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"

namespace procgen {

// grpc.reflection.v1.ServerReflection, also by its older name v1alpha: which services there are,
// and the files that describe them. gRPC's own is not used: it holds a thread for each stream,
// however silent. Threads: any method from any thread.
class ReflectionServiceImpl final : public ByteService {
 public:
  using Request = grpc::reflection::v1::ServerReflectionRequest;
  using Response = grpc::reflection::v1::ServerReflectionResponse;

  // `services`: those that are listed, besides health and this. `accounting` must outlive this.
  ReflectionServiceImpl(const CallAccounting* accounting, std::set<std::string> services);

  // The answer to a request, which is an error in the response where there is no such thing.
  Response Answer(const Request& request);

 private:
  // Adds a file and those that it imports.
  void AddFile(const google::protobuf::FileDescriptor& file);
  void AnswerFile(const google::protobuf::FileDescriptorProto& file, Response* response);
  ByteStream* BeginInfo(grpc::CallbackServerContext* context);

  const CallAccounting* const accounting_;
  std::set<std::string> services_;
  google::protobuf::SimpleDescriptorDatabase files_;  // only read after construction
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_REFLECTION_SERVICE_H_
