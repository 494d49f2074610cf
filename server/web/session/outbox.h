#ifndef SERVER_WEB_SESSION_OUTBOX_H_
#define SERVER_WEB_SESSION_OUTBOX_H_

#include <string>

#include "server/web/json/message.h"

namespace procgen::web {

// Reasons to close a socket, as RFC 6455 numbers them.
inline constexpr int kCloseGoingAway = 1001;
inline constexpr int kCloseBadMessage = 1007;
inline constexpr int kClosePolicy = 1008;

// Where the messages for one page go. None of the methods blocks. Threads: any method from any
// thread.
class Outbox {
 public:
  virtual ~Outbox() = default;

  // Answers the oldest message of the page that is not answered yet. While too many are not, or
  // answers wait to be read, no further message is read from the page.
  virtual void Answer(WireMessage message) = 0;
  // Tells something that must arrive, but for `Forget`, in order with the others.
  virtual void Tell(WireMessage message) = 0;
  // Tells something that the next of the same key makes needless: it takes the place of one that
  // still waits, so that what waits for a slow page does not grow.
  virtual void TellLatest(const std::string& key, WireMessage message) = 0;
  // Drops what waits of a key.
  virtual void Forget(const std::string& key) = 0;
  // The page has said who it is: larger messages are read from it, and it has all the time it
  // wants.
  virtual void Welcome() = 0;
  // Closes the socket after what waits has been written, or after a while.
  virtual void Close(int code, std::string reason) = 0;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_OUTBOX_H_
