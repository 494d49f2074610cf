#include "server/rpc/services/reflection_service.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "google/protobuf/descriptor.pb.h"
#include "grpc/health/v1/health.pb.h"
#include "grpc/reflection/v1alpha/reflection.pb.h"
#include "server/rpc/grpc/parse_message.h"
#include "server/rpc/services/reflection_reactor.h"

namespace procgen {
namespace {

constexpr char kMethod[] = "ServerReflection/ServerReflectionInfo";

void SetNotFound(ReflectionServiceImpl::Response* response) {
  response->mutable_error_response()->set_error_code(static_cast<int>(absl::StatusCode::kNotFound));
  response->mutable_error_response()->set_error_message("this server has no such descriptor");
}

}  // namespace

ReflectionServiceImpl::ReflectionServiceImpl(const CallAccounting* accounting,
                                             std::set<std::string> services)
    : accounting_(accounting), services_(std::move(services)) {
  // References a message of each file, so that the linker keeps the file.
  for (const google::protobuf::Descriptor* message :
       {grpc::health::v1::HealthCheckRequest::descriptor(), Request::descriptor(),
        grpc::reflection::v1alpha::ServerReflectionRequest::descriptor()}) {
    services_.insert(message->file()->service(0)->full_name());
  }
  for (const std::string& service : services_) {
    AddFile(
        *google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(service)->file());
  }
  for (const char* package : {"grpc.reflection.v1.", "grpc.reflection.v1alpha."}) {
    AddByteMethod(absl::StrCat(package, kMethod),
                  [this](auto* context) { return BeginInfo(context); });
  }
}

// NOLINTNEXTLINE(misc-no-recursion): imports are a few levels deep
void ReflectionServiceImpl::AddFile(const google::protobuf::FileDescriptor& file) {
  google::protobuf::FileDescriptorProto copy;
  if (files_.FindFileByName(file.name(), &copy)) {
    return;
  }
  file.CopyTo(&copy);
  files_.Add(copy);
  for (int i = 0; i < file.dependency_count(); ++i) {
    AddFile(*file.dependency(i));
  }
}

void ReflectionServiceImpl::AnswerFile(const google::protobuf::FileDescriptorProto& file,
                                       Response* response) {
  std::vector<google::protobuf::FileDescriptorProto> waiting = {file};
  std::set<std::string> taken = {file.name()};
  while (!waiting.empty()) {
    const google::protobuf::FileDescriptorProto next = std::move(waiting.back());
    waiting.pop_back();
    response->mutable_file_descriptor_response()->add_file_descriptor_proto(
        next.SerializeAsString());
    for (const std::string& name : next.dependency()) {
      if (taken.insert(name).second) {
        files_.FindFileByName(name, &waiting.emplace_back());
      }
    }
  }
}

ReflectionServiceImpl::Response ReflectionServiceImpl::Answer(const Request& request) {
  Response response;
  response.set_valid_host(request.host());
  *response.mutable_original_request() = request;
  google::protobuf::FileDescriptorProto file;
  bool has_file = false;
  switch (request.message_request_case()) {
    case Request::kListServices:
      for (const std::string& service : services_) {
        response.mutable_list_services_response()->add_service()->set_name(service);
      }
      return response;
    case Request::kAllExtensionNumbersOfType: {
      const std::string& type = request.all_extension_numbers_of_type();
      std::vector<int> numbers;
      files_.FindAllExtensionNumbers(type, &numbers);
      if (!numbers.empty() || files_.FindFileContainingSymbol(type, &file)) {
        auto* const found = response.mutable_all_extension_numbers_response();
        found->set_base_type_name(type);
        found->mutable_extension_number()->Add(numbers.begin(), numbers.end());
        return response;
      }
      break;
    }
    case Request::kFileByFilename:
      has_file = files_.FindFileByName(request.file_by_filename(), &file);
      break;
    case Request::kFileContainingSymbol:
      has_file = files_.FindFileContainingSymbol(request.file_containing_symbol(), &file);
      break;
    case Request::kFileContainingExtension:
      has_file = files_.FindFileContainingExtension(
          request.file_containing_extension().containing_type(),
          request.file_containing_extension().extension_number(), &file);
      break;
    case Request::MESSAGE_REQUEST_NOT_SET:
      break;
  }
  if (has_file) {
    AnswerFile(file, &response);
  } else {
    SetNotFound(&response);
  }
  return response;
}

ByteStream* ReflectionServiceImpl::BeginInfo(grpc::CallbackServerContext* context) {
  const auto answer = [this](const grpc::ByteBuffer& bytes) -> absl::StatusOr<grpc::ByteBuffer> {
    Request request;
    if (absl::Status status = ParseMessage(bytes, &request); !status.ok()) {
      return status;
    }
    grpc::ByteBuffer response;
    bool own_buffer = false;
    grpc::SerializationTraits<Response>::Serialize(Answer(request), &response, &own_buffer);
    return response;
  };
  return ReflectionReactor::Start(accounting_, context, answer);
}

}  // namespace procgen
