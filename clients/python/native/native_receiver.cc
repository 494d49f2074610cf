#include "clients/python/native/native_receiver.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

namespace procgen_python {

NativeReceiver::NativeReceiver(std::shared_ptr<procgen_client::StepStream> stream,
                               std::function<std::unique_ptr<procgen_client::Batch>()> take_batch)
    : stream_(std::move(stream)),
      take_batch_(std::move(take_batch)),
      event_file_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      thread_([this] { Run(); }) {}

NativeReceiver::~NativeReceiver() {
  Stop();
  close(event_file_);
}

void NativeReceiver::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    is_ended_ = true;
  }
  if (thread_.joinable()) {
    thread_.join();
    stream_ = nullptr;
  }
}

void NativeReceiver::Begin() {
  absl::MutexLock lock(&mutex_);
  is_wanted_ = true;
}

NativeReceiver::Answer NativeReceiver::Take() {
  uint64_t count = 0;
  static_cast<void>(read(event_file_, &count, sizeof(count)));
  absl::MutexLock lock(&mutex_);
  Answer answer = answer_.has_value()
                      ? *std::move(answer_)
                      : Answer(absl::InternalError("no answer has arrived"), nullptr);
  answer_ = std::nullopt;
  return answer;
}

void NativeReceiver::Run() {
  while (true) {
    {
      absl::MutexLock lock(&mutex_);
      const auto is_due = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return is_wanted_ || is_ended_;
      };
      mutex_.Await(absl::Condition(&is_due));
      if (!is_wanted_) {
        return;
      }
      is_wanted_ = false;
    }
    std::unique_ptr<procgen_client::Batch> batch = take_batch_();
    absl::Status status = stream_->Receive(batch.get());
    {
      absl::MutexLock lock(&mutex_);
      answer_ = Answer(std::move(status), std::move(batch));
    }
    const uint64_t one = 1;
    static_cast<void>(write(event_file_, &one, sizeof(one)));
  }
}

}  // namespace procgen_python
