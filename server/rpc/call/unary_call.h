#ifndef SERVER_RPC_CALL_UNARY_CALL_H_
#define SERVER_RPC_CALL_UNARY_CALL_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "grpcpp/support/byte_buffer.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/call/one_request_stream.h"
#include "server/rpc/grpc/method_name.h"
#include "server/rpc/grpc/parse_message.h"

namespace procgen {

// One call of a unary method. The services take raw bytes and parse them here, because gRPC's own
// parsing answers garbage with UNIMPLEMENTED and no message.
//
// The life of a call: CallAccounting admits it by its headers, the request arrives, and the
// service's function receives it and calls Finish once, on any thread. The call deletes itself when
// gRPC is done with it, as its answer is sent. Until then it counts as one of its owner's calls.
template <typename Request, typename Response>
class UnaryCall final : public OneRequestStream {
 public:
  using Serve = std::function<void(UnaryCall*)>;

  // The owner whose pools the call may access.
  const std::string& owner() const { return caller_.owner; }
  const Request& request() const { return request_; }
  Response* response() { return &response_; }

  // Ends the call with the response or an error.
  void Finish(const absl::Status& status) {
    const absl::Status answered = status.ok() ? Serialize() : status;
    // A reader may be slow: only the serialised response waits for it.
    Request().Swap(&request_);
    Response().Swap(&response_);
    request_reservation_ = Quotas::Reservation();
    if (!answered.ok()) {
      ByteStream::Finish(accounting_.EndCall(MethodNameOf<Request>(), answered));
      return;
    }
    StartWriteAndFinish(&bytes_, grpc::WriteOptions(), grpc::Status::OK);
  }

  // Creates a call. If `accounting` (which must outlive it) admits it, `serve(call)` runs once its
  // request has arrived.
  static ByteStream* Start(const CallAccounting& accounting,
                           const grpc::CallbackServerContext& context, Serve serve) {
    auto* call = new UnaryCall(accounting, std::move(serve));
    absl::StatusOr<Caller> caller = accounting.Admit(context);
    if (!caller.ok()) {
      call->Finish(caller.status());
      return call;
    }
    call->caller_ = *std::move(caller);
    call->ReadRequest(accounting.request_timeout());
    return call;
  }

 private:
  UnaryCall(const CallAccounting& accounting, Serve serve)
      : accounting_(accounting), serve_(std::move(serve)) {}
  ~UnaryCall() override = default;

  void OnRequest(absl::StatusOr<grpc::ByteBuffer> bytes) override {
    absl::Status status = bytes.status();
    if (status.ok()) {
      status = ParseMessage(*bytes, &request_);
    }
    if (status.ok() && bytes->Length() > kLargeMessageBytes) {
      status = Reserve(request_.SpaceUsedLong(), &request_reservation_);
      bytes->Clear();
    }
    if (!status.ok()) {
      Finish(status);
      return;
    }
    serve_(this);
  }

  void OnDone() override { delete this; }

  absl::Status Reserve(size_t bytes, Quotas::Reservation* reservation) {
    absl::StatusOr<Quotas::Reservation> reserved =
        accounting_.ReserveBytes(owner(), static_cast<int64_t>(bytes));
    if (!reserved.ok()) {
      return reserved.status();
    }
    *reservation = *std::move(reserved);
    return absl::OkStatus();
  }

  absl::Status Serialize() {
    const size_t byte_count = response_.ByteSizeLong();
    if (byte_count > kLargeMessageBytes) {
      if (absl::Status status = Reserve(byte_count, &response_reservation_); !status.ok()) {
        return status;
      }
    }
    bool own_buffer = false;
    return grpc::SerializationTraits<Response>::Serialize(response_, &bytes_, &own_buffer).ok()
               ? absl::OkStatus()
               : absl::InternalError("the response cannot be serialised");
  }

  const CallAccounting& accounting_;
  const Serve serve_;
  Caller caller_;
  Quotas::Reservation request_reservation_;  // of large messages
  Quotas::Reservation response_reservation_;
  Request request_;
  Response response_;
  grpc::ByteBuffer bytes_;  // of the response
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_UNARY_CALL_H_
