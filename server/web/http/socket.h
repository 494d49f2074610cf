#ifndef SERVER_WEB_HTTP_SOCKET_H_
#define SERVER_WEB_HTTP_SOCKET_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "boost/beast/core/tcp_stream.hpp"
#include "boost/beast/http/empty_body.hpp"
#include "boost/beast/http/message.hpp"
#include "boost/beast/ssl/ssl_stream.hpp"
#include "server/concurrency/steady_time.h"
#include "server/concurrency/thread_group.h"
#include "server/web/session/outbox.h"
#include "server/web/session/page_session.h"

namespace procgen::web {

using PlainStream = boost::beast::tcp_stream;
using SecureStream = boost::beast::ssl_stream<boost::beast::tcp_stream>;
using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;

// All WebSockets that are open. Threads: any method from any thread.
class OpenSockets {
 public:
  OpenSockets(const PageSessionContext& context, ThreadGroup* threads)
      : context_(context), threads_(threads) {}

  // Each goes on with a connection as a WebSocket, with a page session on a thread of its own.
  void Open(PlainStream stream, const UpgradeRequest& request);
  void Open(SecureStream stream, const UpgradeRequest& request);

  // Tells all pages that the server stops, has their sessions stop, and closes the sockets; those
  // of pages that do not answer are broken after a while.
  void BeginClose();
  // Waits until all have gone, `timeout` at most.
  void AwaitClosed(absl::Duration timeout);

 private:
  template <typename Stream>
  friend class Socket;

  // What closing takes.
  class Closable {
   public:
    virtual ~Closable() = default;
    virtual void BeginClose() = 0;
  };

  template <typename Stream>
  void OpenOn(Stream stream, const UpgradeRequest& request);
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
