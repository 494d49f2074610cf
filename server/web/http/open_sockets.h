#ifndef SERVER_WEB_HTTP_OPEN_SOCKETS_H_
#define SERVER_WEB_HTTP_OPEN_SOCKETS_H_

#include <map>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "server/concurrency/steady_time.h"

namespace procgen::web {

// The set of open WebSockets, for their shutdown. Threads: any method from any thread.
class OpenSockets {
 public:
  class Closable {
   public:
    virtual ~Closable() = default;
    // Notifies the page that the server stops and closes the socket. An unresponsive page is
    // disconnected after a timeout. From any thread.
    virtual void BeginClose() = 0;
  };

  // Adds a socket until Remove. False: the server stops, and the socket must not be served.
  bool Add(const std::shared_ptr<Closable>& socket);
  void Remove(const Closable* socket);

  // Closes all sockets.
  void BeginClose();
  // Waits until all are removed, at most `timeout`.
  void AwaitClosed(absl::Duration timeout);

 private:
  absl::Mutex mutex_;
  SteadyCondVar removed_;
  bool is_closing_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<const Closable*, std::weak_ptr<Closable>> sockets_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_OPEN_SOCKETS_H_
