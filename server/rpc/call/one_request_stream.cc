#include "server/rpc/call/one_request_stream.h"

#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/grpc/grpc_deadline.h"

namespace procgen {

void OneRequestStream::ReadRequest(absl::Duration timeout) {
  waiting_ = std::make_shared<std::atomic<OneRequestStream*>>(this);
  alarm_.Set(GrpcDeadlineIn(timeout), [waiting = waiting_, timeout](bool has_expired) {
    // Either the timeout or OnReadDone takes the stream and continues. Until then it is not
    // deleted.
    OneRequestStream* const stream = has_expired ? waiting->exchange(nullptr) : nullptr;
    if (stream != nullptr) {
      stream->OnRequest(absl::DeadlineExceededError(
          absl::StrCat("the request has not arrived within ", absl::FormatDuration(timeout),
                       ", limit attach_timeout")));
    }
  });
  StartRead(&request_);
}

void OneRequestStream::OnReadDone(bool ok) {
  if (waiting_->exchange(nullptr) == nullptr) {
    return;
  }
  alarm_.Cancel();
  if (!ok) {
    OnRequest(absl::CancelledError("the call ended before its request arrived"));
    return;
  }
  OnRequest(std::move(request_));
}

}  // namespace procgen
