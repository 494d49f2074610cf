#include "server/rpc/call/byte_service.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "grpcpp/impl/codegen/server_callback_handlers.h"
#include "grpcpp/impl/rpc_method.h"
#include "grpcpp/impl/rpc_service_method.h"

namespace procgen {

void ByteService::AddByteMethod(absl::string_view method, Begin begin) {
  const std::string& name = names_.emplace_back(absl::StrCat("/", method));
  AddMethod(new grpc::internal::RpcServiceMethod(
      name.c_str(), grpc::internal::RpcMethod::BIDI_STREAMING, nullptr));
  MarkMethodRawCallback(method_count_++,
                        new grpc::internal::CallbackBidiHandler<grpc::ByteBuffer, grpc::ByteBuffer>(
                            std::move(begin)));
}

std::string ByteService::service_name() const {
  const std::string& method = names_.front();
  return method.substr(1, method.find('/', 1) - 1);
}

}  // namespace procgen
