#ifndef SERVER_RPC_UNARY_CALL_H_
#define SERVER_RPC_UNARY_CALL_H_

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/caller.h"
#include "server/rpc/method_name.h"

namespace procgen {

template <typename Message>
absl::Status ParsedStatus(bool is_valid, size_t byte_count) {
  return is_valid ? absl::OkStatus()
                  : absl::InvalidArgumentError(absl::StrCat("the request's ", byte_count,
                                                            " bytes are no valid ",
                                                            Message::descriptor()->full_name()));
}

// The bytes on the wire as a message. Errors: INVALID_ARGUMENT; CANCELLED: there are none, for the
// call was given up before they came.
template <typename Message>
absl::Status ParseMessage(absl::string_view bytes, Message* message) {
  return ParsedStatus<Message>(
      message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size())), bytes.size());
}
template <typename Message>
absl::Status ParseMessage(const grpc::ByteBuffer& bytes, Message* message) {
  if (!bytes.Valid()) {
    return absl::CancelledError("the call ended before its request came");
  }
  // Small requests, which come in one piece, are read as they lie: gRPC's reader of many pieces
  // takes 2 us longer.
  if (grpc::Slice piece; bytes.TrySingleSlice(&piece).ok()) {
    return ParseMessage(
        absl::string_view(reinterpret_cast<const char*>(piece.begin()), piece.size()), message);
  }
  grpc::ByteBuffer consumed(bytes);  // shares the bytes
  const bool is_valid = grpc::SerializationTraits<Message>::Deserialize(&consumed, message).ok();
  return ParsedStatus<Message>(is_valid, bytes.Length());
}

// One call of a unary method. The services take raw bytes and parse them here, because gRPC's own
// parsing answers garbage with UNIMPLEMENTED and no message.
//
// The life of a call: it is let in (Callers), made, and handed to the service's function, which
// calls Finish once, on any thread, and not after; it ends itself when gRPC has done with it, which
// is when the answer is on its way. Until then it counts as one of its owner's.
template <typename Request, typename Response>
class UnaryCall final : public grpc::ServerUnaryReactor {
 public:
  // Whose pools it may see.
  const std::string& owner() const { return caller_.owner; }
  const Request& request() const { return request_; }
  Response* response() { return &response_; }

  // Answers with the response, or with an error.
  void Finish(const absl::Status& status) {
    if (status.ok()) {
      bool own_buffer = false;
      const grpc::Status serialized =
          grpc::SerializationTraits<Response>::Serialize(response_, bytes_, &own_buffer);
      grpc::ServerUnaryReactor::Finish(serialized);
      return;
    }
    grpc::ServerUnaryReactor::Finish(callers_.Dismiss(MethodNameOf<Request>(), status));
  }

  // Makes a call and, if `callers` (which must outlive it) let it in, has `serve(call)` serve it.
  template <typename Serve>
  static grpc::ServerUnaryReactor* Start(const Callers& callers,
                                         const grpc::CallbackServerContext& context,
                                         const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response, Serve serve) {
    auto* call = new UnaryCall(callers, response);
    absl::StatusOr<Caller> caller = callers.Admit(context);
    absl::Status status = caller.status();
    if (status.ok()) {
      call->caller_ = *std::move(caller);
      status = ParseMessage(*request, &call->request_);
    }
    if (!status.ok()) {
      call->Finish(status);
    } else {
      serve(call);
    }
    return call;
  }

 private:
  UnaryCall(const Callers& callers, grpc::ByteBuffer* bytes) : callers_(callers), bytes_(bytes) {}
  ~UnaryCall() override = default;

  void OnDone() override { delete this; }

  const Callers& callers_;
  grpc::ByteBuffer* const bytes_;
  Caller caller_;
  Request request_;
  Response response_;
};

}  // namespace procgen

#endif  // SERVER_RPC_UNARY_CALL_H_
