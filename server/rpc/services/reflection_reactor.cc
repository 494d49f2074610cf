#include "server/rpc/services/reflection_reactor.h"

#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/grpc/grpc_deadline.h"

namespace procgen {

ByteStream* ReflectionReactor::Start(const CallAccounting* accounting,
                                     grpc::CallbackServerContext* context, Answer answer) {
  std::shared_ptr<ReflectionReactor> reactor(
      new ReflectionReactor(accounting, context, std::move(answer)));
  reactor->self_ = reactor;
  // Weak, because the stream owns the alarm, which owns its callback.
  reactor->alarm_.Set(GrpcDeadlineIn(accounting->request_timeout()),
                      [weak = reactor->weak_from_this()](bool has_expired) {
                        const std::shared_ptr<ReflectionReactor> stream = weak.lock();
                        if (has_expired && stream != nullptr) {
                          stream->OnTimeout();
                        }
                      });
  reactor->StartRead(&reactor->request_);
  return reactor.get();
}

ReflectionReactor::ReflectionReactor(const CallAccounting* accounting,
                                     grpc::CallbackServerContext* context, Answer answer)
    : accounting_(accounting), context_(context), answer_(std::move(answer)) {}

void ReflectionReactor::OnReadDone(bool ok) {
  absl::StatusOr<grpc::ByteBuffer> response = grpc::ByteBuffer();
  if (ok) {
    response = answer_(request_);
  }
  absl::MutexLock lock(&mutex_);
  if (!ok || !response.ok()) {
    End(response.status());
    return;
  }
  response_ = *std::move(response);
  if (!ended_) {
    writes_ = true;
    StartWrite(&response_);
  }
}

void ReflectionReactor::OnWriteDone(bool ok) {
  absl::MutexLock lock(&mutex_);
  writes_ = false;
  if (!ok) {
    End(absl::OkStatus());
  } else if (!ended_) {
    StartRead(&request_);
  }
}

void ReflectionReactor::OnTimeout() {
  absl::MutexLock lock(&mutex_);
  if (writes_) {
    // The client does not read. The cancellation fails the write, which ends the stream.
    context_->TryCancel();
    return;
  }
  End(absl::DeadlineExceededError(absl::StrCat("the stream has not ended within ",
                                               absl::FormatDuration(accounting_->request_timeout()),
                                               ", limit attach_timeout")));
}

void ReflectionReactor::End(const absl::Status& status) {
  if (!std::exchange(ended_, true)) {
    Finish(accounting_->EndCall("ServerReflection/ServerReflectionInfo", status));
  }
}

void ReflectionReactor::OnDone() {
  alarm_.Cancel();
  const std::shared_ptr<ReflectionReactor> last = std::move(self_);
}

}  // namespace procgen
