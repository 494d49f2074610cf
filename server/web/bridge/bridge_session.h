#ifndef SERVER_WEB_BRIDGE_BRIDGE_SESSION_H_
#define SERVER_WEB_BRIDGE_BRIDGE_SESSION_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "procgen/web/v1/bridge.pb.h"
#include "server/rpc/bridge/generic_call.h"

namespace procgen::web {

// Calls of a page at a time.
inline constexpr size_t kCallsMax = 64;
// Requests that wait to be sent: of each call, and bytes of all calls. At a limit no message of the
// page is taken.
inline constexpr size_t kUnsentMax = 16;
inline constexpr size_t kUnsentBytesMax = 1 << 20;
// Largest message that is sent before larger ones.
inline constexpr size_t kSmallBytesMax = 64 << 10;

// Why a socket is closed (RFC 6455).
struct CloseReason {
  int code = 0;
  std::string text;
};
inline constexpr int kCloseGoingAway = 1001;
inline constexpr int kCloseUnsupported = 1003;
inline constexpr int kCloseBadMessage = 1007;
inline constexpr int kClosePolicy = 1008;
inline constexpr int kCloseTryAgainLater = 1013;

// The calls of one page: the protocol of proto/procgen/web/v1/bridge.proto, without its socket.
// Threads: one at a time, of a strand.
class BridgeSession : public std::enable_shared_from_this<BridgeSession> {
 public:
  // Runs a function on the strand. Called on any thread, until all calls have ended.
  using Post = std::function<void(absl::AnyInvocable<void()>)>;

  // `stub` must outlive this. `on_change` is called when Next or CanTake may have changed.
  BridgeSession(GenericStub* stub, Post post, std::function<void()> on_change)
      : stub_(stub), post_(std::move(post)), on_change_(std::move(on_change)) {}
  ~BridgeSession() { Stop(); }
  BridgeSession(const BridgeSession&) = delete;
  BridgeSession& operator=(const BridgeSession&) = delete;

  // Whether the next message of the page may be taken.
  bool CanTake() const;
  // Handles a message of the page. Returns why the socket must be closed, if it must.
  std::optional<CloseReason> Take(absl::string_view bytes);

  // Returns the next message to the page, if there is one. Calls take turns.
  std::optional<std::string> Next();
  // The message of the last Next was written: its call may read the following one.
  void OnWritten();

  // Whether a method of the API has answered, so the server accepts the page's token.
  bool is_accepted() const { return is_accepted_; }

  // Cancels all calls. Nothing follows.
  void Stop();

 private:
  struct Call {
    std::shared_ptr<GenericCall> call;  // null: it could not be started
    bool is_of_api = false;
    std::deque<std::string> unsent;  // the first is being written if is_writing
    bool is_writing = false;
    bool is_half_closed = false;         // by the page
    std::optional<std::string> message;  // for the page
    std::optional<CallEnd> end;
    bool is_queued = false;
  };
  class Observer;

  std::optional<CloseReason> Open(uint32_t number, const std::string& method);
  static void WriteNext(Call* call);
  // Runs `event` with the call on the strand.
  void OnEvent(uint32_t number, absl::AnyInvocable<void(Call*)> event);
  void End(Call* call, CallEnd end);
  void Queue(uint32_t number, Call* call);

  GenericStub* const stub_;
  const Post post_;
  const std::function<void()> on_change_;
  std::string token_;
  std::map<uint32_t, Call> calls_;
  std::deque<uint32_t> small_;  // calls with something for the page, in the order of their turns
  std::deque<uint32_t> large_;  // those whose message is large
  size_t unsent_bytes_ = 0;
  std::optional<uint32_t> written_;  // call of the message that is being written
  bool is_accepted_ = false;
  bool is_stopped_ = false;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_BRIDGE_BRIDGE_SESSION_H_
