#include "server/rpc/watch/latest_stream.h"

#include <utility>

namespace procgen {

LatestStream::LatestStream(const CallAccounting* accounting, absl::string_view method)
    : accounting_(accounting), method_(method) {}

void LatestStream::Send(Response response) {
  {
    absl::MutexLock lock(&mutex_);
    waiting_ = std::move(response);
  }
  Continue();
}

bool LatestStream::IsIdle() {
  absl::MutexLock lock(&mutex_);
  return !writes_ && waiting_ == nullptr;
}

void LatestStream::Close(const absl::Status& status) {
  {
    absl::MutexLock lock(&mutex_);
    if (end_.has_value()) {
      return;
    }
    end_ = status;
  }
  Continue();
}

void LatestStream::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    writes_ = false;
    if (!ok && !end_.has_value()) {
      end_ = absl::OkStatus();  // the client has disconnected
    }
  }
  Continue();
}

void LatestStream::OnCancel() { Close(absl::OkStatus()); }

void LatestStream::OnDone() {
  ReleaseSource();
  const std::shared_ptr<LatestStream> last = std::move(self_);
}

void LatestStream::Continue() {
  Response response;
  std::optional<absl::Status> end;
  {
    absl::MutexLock lock(&mutex_);
    if (writes_ || ended_ || !(end_.has_value() || waiting_ != nullptr)) {
      return;
    }
    end = end_;
    ended_ = end.has_value();
    writes_ = !ended_;
    response = std::exchange(waiting_, nullptr);
  }
  if (end.has_value()) {
    Finish(accounting_->EndCall(method_, *end));
    return;
  }
  written_ = response();
  StartWrite(&written_);
}

}  // namespace procgen
