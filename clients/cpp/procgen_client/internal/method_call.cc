#include "procgen_client/internal/method_call.h"

#include <vector>

#include "absl/time/clock.h"
#include "grpcpp/client_context.h"
#include "grpcpp/completion_queue.h"
#include "grpcpp/generic/generic_stub.h"
#include "procgen_client/credentials.h"
#include "procgen_client/internal/grpc_error.h"

namespace procgen_client {

grpc::ByteBuffer ByteBufferOf(absl::string_view message) {
  const grpc::Slice slice(message.data(), message.size());
  return {&slice, 1};
}

std::string BytesOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string bytes;
  if (buffer.Dump(&slices).ok()) {
    bytes.reserve(buffer.Length());
    for (const grpc::Slice& slice : slices) {
      bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
  }
  return bytes;
}

absl::StatusOr<std::string> CallMethod(const std::shared_ptr<grpc::Channel>& channel,
                                       const CallOptions& options, const std::string& path,
                                       absl::string_view request) {
  grpc::ClientContext context;
  const OpenCalls::Entry entry(options.calls, [&context] { context.TryCancel(); });
  ShowToken(options.token, &context);
  if (options.timeout != absl::InfiniteDuration()) {
    context.set_deadline(absl::ToChronoTime(absl::Now() + options.timeout));
  }
  grpc::GenericStub stub(channel);
  grpc::ByteBuffer response;
  grpc::Status status;
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareUnaryCall(&context, path, ByteBufferOf(request), &queue);
  call->StartCall();
  call->Finish(&response, &status, nullptr);
  queue.Shutdown();
  void* tag = nullptr;
  for (bool is_ok = false; queue.Next(&tag, &is_ok);) {
  }
  if (!status.ok()) {
    return ToAbslStatus(status);
  }
  return BytesOf(response);
}

}  // namespace procgen_client
