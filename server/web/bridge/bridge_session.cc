#include "server/web/bridge/bridge_session.h"

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace procgen::web {
namespace {

// Methods of the API need the page's token; those of gRPC's own services do not.
constexpr absl::string_view kApi = "/procgen.";

CloseReason OutOfPlace(const std::string& text) { return {kClosePolicy, text}; }

}  // namespace

// Passes what happens in a call to the strand of its session, unless the page has gone.
class BridgeSession::Observer final : public GenericCallObserver {
 public:
  Observer(std::weak_ptr<BridgeSession> session, Post post, uint32_t number)
      : session_(std::move(session)), post_(std::move(post)), number_(number) {}

  void OnMessage(std::string message) override {
    PostEvent([message = std::move(message)](BridgeSession* session, uint32_t number) mutable {
      session->OnEvent(number, [session, number, &message](Call* call) {
        call->message = std::move(message);
        session->is_accepted_ |= call->is_of_api;
        session->Queue(number, call);
      });
    });
  }

  void OnWritten() override {
    PostEvent([](BridgeSession* session, uint32_t number) {
      session->OnEvent(number, [session](Call* call) {
        call->is_writing = false;
        session->unsent_bytes_ -= call->unsent.front().size();
        call->unsent.pop_front();
        WriteNext(call);
      });
    });
  }

  void OnEnd(const CallEnd& end) override {
    PostEvent([end](BridgeSession* session, uint32_t number) {
      session->OnEvent(number, [session, number, &end](Call* call) {
        session->End(call, end);
        session->Queue(number, call);
      });
    });
  }

 private:
  // Does not keep the session, whose destructor runs on its strand.
  template <typename Event>
  void PostEvent(Event event) {
    post_([weak = session_, number = number_, event = std::move(event)]() mutable {
      if (const std::shared_ptr<BridgeSession> session = weak.lock(); session != nullptr) {
        event(session.get(), number);
      }
    });
  }

  const std::weak_ptr<BridgeSession> session_;
  const Post post_;
  const uint32_t number_;
};

bool BridgeSession::CanTake() const {
  // A call beyond the limit occupies a place until the page was told so.
  return calls_.size() <= kCallsMax && unsent_bytes_ < kUnsentBytesMax &&
         std::all_of(calls_.begin(), calls_.end(),
                     [](const auto& entry) { return entry.second.unsent.size() < kUnsentMax; });
}

std::optional<CloseReason> BridgeSession::Take(absl::string_view bytes) {
  v1::BridgeRequest request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return CloseReason{kCloseBadMessage, "the message is no BridgeRequest"};
  }
  const uint32_t number = request.call();
  if (request.has_token() != (number == 0)) {
    return OutOfPlace(absl::StrCat("call is ", number, ", allowed: 0 with token, else not 0"));
  }
  if (request.has_token()) {
    token_ = request.token();
    return std::nullopt;
  }
  if (request.has_method()) {
    return Open(number, request.method());
  }
  if (request.request_case() == v1::BridgeRequest::REQUEST_NOT_SET) {
    return OutOfPlace(absl::StrCat("the request of call ", number, " is empty"));
  }
  const auto found = calls_.find(number);
  if (found == calls_.end() || found->second.end.has_value()) {
    return std::nullopt;  // the page does not know yet that it has ended
  }
  Call* const call = &found->second;
  if (request.cancel()) {
    call->call->Cancel();
  } else if (request.has_message() || request.half_close()) {
    if (call->is_half_closed) {
      return OutOfPlace(absl::StrCat("call ", number, " is half-closed"));
    }
    if (request.has_message()) {
      unsent_bytes_ += request.message().size();
      call->unsent.push_back(std::move(*request.mutable_message()));
    } else {
      call->is_half_closed = true;
    }
    WriteNext(call);
  }
  return std::nullopt;
}

std::optional<CloseReason> BridgeSession::Open(uint32_t number, const std::string& method) {
  const auto [entry, is_new] = calls_.try_emplace(number);
  if (!is_new) {
    return OutOfPlace(absl::StrCat("call ", number, " is in use"));
  }
  Call* const call = &entry->second;
  call->is_of_api = absl::StartsWith(method, kApi);
  absl::StatusOr<std::shared_ptr<GenericCall>> started =
      calls_.size() > kCallsMax
          ? absl::ResourceExhaustedError(
                absl::StrCat("the page has ", kCallsMax, " calls in progress, the maximum"))
          : stub_->Start(method, token_,
                         std::make_shared<Observer>(weak_from_this(), post_, number));
  if (started.ok()) {
    call->call = *std::move(started);
    call->call->Read();
  } else {
    End(call, {.status = started.status()});
    Queue(number, call);
  }
  return std::nullopt;
}

void BridgeSession::WriteNext(Call* call) {
  if (call->is_writing) {
    return;
  }
  if (!call->unsent.empty()) {
    call->is_writing = true;
    call->call->Write(call->unsent.front());
  } else if (call->is_half_closed) {
    call->call->HalfClose();
  }
}

void BridgeSession::OnEvent(uint32_t number, absl::AnyInvocable<void(Call*)> event) {
  if (is_stopped_) {
    return;
  }
  // The end of a call is its last event, so this is not another call of the same number.
  event(&calls_.at(number));
  on_change_();
}

void BridgeSession::End(Call* call, CallEnd end) {
  for (const std::string& message : call->unsent) {
    unsent_bytes_ -= message.size();
  }
  call->unsent.clear();
  call->end = std::move(end);
}

void BridgeSession::Queue(uint32_t number, Call* call) {
  if (!std::exchange(call->is_queued, true)) {
    const bool is_large = call->message.has_value() && call->message->size() > kSmallBytesMax;
    (is_large ? large_ : small_).push_back(number);
  }
}

std::optional<std::string> BridgeSession::Next() {
  std::deque<uint32_t>* const queue = small_.empty() ? &large_ : &small_;
  if (queue->empty()) {
    return std::nullopt;
  }
  const uint32_t number = queue->front();
  queue->pop_front();
  Call* const call = &calls_.at(number);
  call->is_queued = false;
  v1::BridgeResponse response;
  response.set_call(number);
  if (call->message.has_value()) {
    response.set_message(*std::exchange(call->message, std::nullopt));
    written_ = number;
    if (call->end.has_value()) {
      Queue(number, call);
    }
  } else {
    v1::Status* const end = response.mutable_end();
    end->set_code(static_cast<int32_t>(call->end->status.code()));
    end->set_message(std::string(call->end->status.message()));
    end->set_draining(call->end->is_draining);
    calls_.erase(number);
  }
  return response.SerializeAsString();
}

void BridgeSession::OnWritten() {
  if (const std::optional<uint32_t> number = std::exchange(written_, std::nullopt);
      number.has_value()) {
    if (const auto call = calls_.find(*number);
        call != calls_.end() && !call->second.end.has_value()) {
      call->second.call->Read();
    }
  }
}

void BridgeSession::Stop() {
  is_stopped_ = true;
  for (auto& [number, call] : calls_) {
    if (call.call != nullptr && !call.end.has_value()) {
      call.call->Cancel();
    }
  }
  calls_.clear();
  small_.clear();
  large_.clear();
}

}  // namespace procgen::web
