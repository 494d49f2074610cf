#include "tests/service/raw_call.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "grpcpp/client_context.h"
#include "grpcpp/completion_queue.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/support/byte_buffer.h"

namespace procgen {
namespace {

// Waits for the pending operation.
bool Next(grpc::CompletionQueue* queue) {
  void* tag = nullptr;
  bool ok = false;
  return queue->Next(&tag, &ok) && ok;
}

std::string BytesOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string bytes;
  if (buffer.Dump(&slices).ok()) {
    for (const grpc::Slice& slice : slices) {
      bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
  }
  return bytes;
}

}  // namespace

RawResult CallRaw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                  const std::vector<std::string>& requests, const std::string& token,
                  size_t response_count_max) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  if (!token.empty()) {
    context.AddMetadata("authorization", "Bearer " + token);
  }
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareCall(&context, method, &queue);
  call->StartCall(nullptr);
  bool open = Next(&queue);
  for (size_t i = 0; i < requests.size() && open; ++i) {
    const grpc::Slice slice(requests[i]);
    call->Write(grpc::ByteBuffer(&slice, 1), nullptr);
    open = Next(&queue);
  }
  if (open) {
    call->WritesDone(nullptr);
    Next(&queue);
  }
  RawResult result;
  grpc::ByteBuffer response;
  call->Read(&response, nullptr);
  while (Next(&queue)) {
    result.responses.push_back(BytesOf(response));
    if (result.responses.size() == response_count_max) {
      context.TryCancel();
    }
    call->Read(&response, nullptr);
  }
  grpc::Status status;
  call->Finish(&status, nullptr);
  Next(&queue);
  if (result.responses.size() >= response_count_max) {
    return result;
  }
  result.status =
      absl::Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
  return result;
}

int ConnectTo(const std::string& address) {
  const int connection = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in peer = {};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  peer.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int status = connect(connection, reinterpret_cast<sockaddr*>(&peer), sizeof(peer));
  return status == 0 ? connection : -1;
}

}  // namespace procgen
