#include "server/rpc/grpc/method_name.h"

#include "absl/strings/str_cat.h"

namespace procgen {

std::string MethodNameOf(const google::protobuf::Descriptor& request) {
  const google::protobuf::FileDescriptor& file = *request.file();
  for (int i = 0; i < file.service_count(); ++i) {
    const google::protobuf::ServiceDescriptor& service = *file.service(i);
    for (int j = 0; j < service.method_count(); ++j) {
      if (service.method(j)->input_type() == &request) {
        return absl::StrCat(service.name(), "/", service.method(j)->name());
      }
    }
  }
  return "";
}

std::string FullMethodNameOf(const google::protobuf::Descriptor& request) {
  return absl::StrCat(request.file()->package(), ".", MethodNameOf(request));
}

}  // namespace procgen
