#include "procgen_client/message_watch.h"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "grpcpp/client_context.h"
#include "grpcpp/generic/generic_stub.h"
#include "procgen_client/credentials.h"
#include "procgen_client/internal/grpc_error.h"
#include "procgen_client/internal/method_call.h"

namespace procgen_client {

struct MessageWatch::State {
  std::mutex mutex;
  std::condition_variable has_changed;
  // Under mutex:
  std::optional<grpc::ByteBuffer> latest;  // not returned yet
  absl::Status end;                        // of the stream; OK while it is open
  bool is_stopped = false;
  bool is_done = false;  // no reaction follows
};

// Reads all messages of the stream.
class MessageWatch::Call final
    : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  Call(const std::shared_ptr<grpc::Channel>& channel, const std::string& token,
       const std::string& path, absl::string_view request, std::shared_ptr<State> state)
      : state_(std::move(state)), request_(ByteBufferOf(request)) {
    ShowToken(token, &context_);
    grpc::GenericStub(channel).PrepareBidiStreamingCall(&context_, path, /*options=*/{}, this);
    StartWriteLast(&request_, grpc::WriteOptions());
    StartRead(&response_);
    StartCall();
  }

  void Cancel() { context_.TryCancel(); }

  void OnReadDone(bool ok) override {
    if (!ok) {
      return;
    }
    {
      const std::lock_guard lock(state_->mutex);
      state_->latest = std::exchange(response_, {});
      state_->has_changed.notify_all();
    }
    StartRead(&response_);
  }

  void OnDone(const grpc::Status& status) override {
    const std::shared_ptr<State> state = state_;  // this may be deleted once is_done is set
    const std::lock_guard lock(state->mutex);
    state->end =
        status.ok() ? absl::UnavailableError("the server ended the stream") : ToAbslStatus(status);
    state->is_done = true;
    state->has_changed.notify_all();
  }

 private:
  const std::shared_ptr<State> state_;
  grpc::ClientContext context_;
  const grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;
};

MessageWatch::MessageWatch(const std::shared_ptr<grpc::Channel>& channel,
                           const CallOptions& options, const std::string& path,
                           absl::string_view request)
    : state_(std::make_shared<State>()),
      call_(std::make_unique<Call>(channel, options.token, path, request, state_)),
      entry_(options.calls, [this] { Stop(); }) {}

MessageWatch::~MessageWatch() {
  Stop();
  std::unique_lock lock(state_->mutex);
  state_->has_changed.wait(lock, [this] { return state_->is_done; });
}

absl::StatusOr<std::optional<std::string>> MessageWatch::Next(
    std::chrono::duration<double> timeout) {
  std::optional<grpc::ByteBuffer> message;
  {
    std::unique_lock lock(state_->mutex);
    const auto has_changed = [this] {
      return state_->latest.has_value() || !state_->end.ok() || state_->is_stopped;
    };
    if (timeout < std::chrono::duration<double>::zero()) {
      state_->has_changed.wait(lock, has_changed);
    } else {
      state_->has_changed.wait_for(lock, timeout, has_changed);
    }
    if (state_->is_stopped) {
      return absl::CancelledError("the watch was stopped");
    }
    message = std::exchange(state_->latest, std::nullopt);
    if (!message.has_value() && !state_->end.ok()) {
      return state_->end;
    }
  }
  if (!message.has_value()) {
    return std::nullopt;
  }
  return BytesOf(*message);
}

void MessageWatch::Stop() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->is_stopped = true;
    state_->has_changed.notify_all();
  }
  call_->Cancel();
}

}  // namespace procgen_client
