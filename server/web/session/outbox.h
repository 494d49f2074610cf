#ifndef SERVER_WEB_SESSION_OUTBOX_H_
#define SERVER_WEB_SESSION_OUTBOX_H_

#include <string>

#include "absl/functional/any_invocable.h"
#include "server/web/json/message.h"

namespace procgen::web {

// WebSocket close codes (RFC 6455).
inline constexpr int kCloseGoingAway = 1001;
inline constexpr int kCloseBadMessage = 1007;
inline constexpr int kClosePolicy = 1008;

// Queue of messages to one page. No method blocks. Threads: any method from any thread.
class Outbox {
 public:
  virtual ~Outbox() = default;

  // Answers the oldest unanswered message of the page. While too many messages are unanswered, or
  // answers unread, no further message is read from the page.
  virtual void Answer(WireMessage message) = 0;
  // Sends a message that must arrive, in order with the others.
  virtual void SendEvent(WireMessage message) = 0;
  // Sends a message that replaces a queued one with the same key, so that the queue of a slow page
  // does not grow.
  virtual void SendLatestEvent(const std::string& key, WireMessage message) = 0;
  // Sends frames after all other queued messages. Replaces queued frames with the same key, so that
  // a slow page gets the newest. `compose` is called once, when it is their turn, or never if they
  // are replaced; calls of a page are in order, one at a time.
  virtual void SendFrames(const std::string& key, absl::AnyInvocable<WireMessage()> compose) = 0;
  // Drops the queued message or frames of `key`.
  virtual void DropEvent(const std::string& key) = 0;
  // Called when hello is accepted: lifts the limits on message size and time of an unidentified
  // page.
  virtual void AcceptHello() = 0;
  // Closes the socket after the queued messages are written, or after a timeout.
  virtual void Close(int code, std::string reason) = 0;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_OUTBOX_H_
