#include "server/web/http/open_sockets.h"

#include <vector>

namespace procgen::web {

bool OpenSockets::Add(const std::shared_ptr<Closable>& socket) {
  absl::MutexLock lock(&mutex_);
  if (is_closing_) {
    return false;
  }
  sockets_[socket.get()] = socket;
  return true;
}

void OpenSockets::Remove(const Closable* socket) {
  absl::MutexLock lock(&mutex_);
  sockets_.erase(socket);
  removed_.NotifyAll();
}

void OpenSockets::BeginClose() {
  std::vector<std::shared_ptr<Closable>> sockets;
  {
    absl::MutexLock lock(&mutex_);
    is_closing_ = true;
    for (const auto& [key, socket] : sockets_) {
      sockets.push_back(socket.lock());
    }
  }
  for (const std::shared_ptr<Closable>& socket : sockets) {
    if (socket != nullptr) {
      socket->BeginClose();
    }
  }
}

void OpenSockets::AwaitClosed(absl::Duration timeout) {
  absl::MutexLock lock(&mutex_);
  const auto have_gone = [this]()
                             ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return sockets_.empty(); };
  removed_.AwaitUntil(&mutex_, SteadyNow() + timeout, have_gone);
}

}  // namespace procgen::web
