#ifndef SERVER_WEB_HTTP_SOCKET_H_
#define SERVER_WEB_HTTP_SOCKET_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "boost/beast/http/empty_body.hpp"
#include "boost/beast/http/message.hpp"
#include "server/concurrency/steady_time.h"
#include "server/concurrency/thread_group.h"
#include "server/web/http/byte_stream.h"
#include "server/web/session/outbox.h"
#include "server/web/session/page_session.h"

namespace procgen::web {

using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;

// The set of open WebSockets. Threads: any method from any thread.
class OpenSockets {
 public:
  OpenSockets(const PageSessionContext& context, ThreadGroup* threads)
      : context_(context), threads_(threads) {}

  // Upgrades a connection to a WebSocket and runs its page session on a new thread.
  void Open(ByteStream stream, const UpgradeRequest& request);

  // Notifies all pages that the server stops, stops their sessions and closes the sockets. Sockets
  // of unresponsive pages are aborted after a timeout.
  void BeginClose();
  // Waits until all sockets are closed, at most `timeout`.
  void AwaitClosed(absl::Duration timeout);

 private:
  friend class Socket;

  // Interface of a socket for shutdown.
  class Closable {
   public:
    virtual ~Closable() = default;
    virtual void BeginClose() = 0;
  };

  void Remove(const Closable* socket);

  const PageSessionContext& context_;
  ThreadGroup* const threads_;
  absl::Mutex mutex_;
  SteadyCondVar removed_;
  bool is_closing_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<const Closable*, std::weak_ptr<Closable>> sockets_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_SOCKET_H_
