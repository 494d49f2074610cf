#ifndef SERVER_NET_LISTENER_H_
#define SERVER_NET_LISTENER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/net/address.h"

namespace procgen {

// The listening sockets of a server, and a thread that accepts connections. gRPC's own listener
// stops permanently once the process runs out of file descriptors, so a caller could disable it.
// This one continues when descriptors are available, and leaves some for files. Threads: one at a
// time.
class Listener {
 public:
  // Descriptors of the process, unless it may open fewer. Connections leave an eighth of them for
  // files.
  static constexpr int kDescriptorsMax = 4608;

  // Takes ownership of an accepted `connection`. `listening`: the socket that accepted it.
  using Take = std::function<void(int listening, int connection)>;

  // Listens without accepting yet. Port 0: any free port. An existing socket file is removed if
  // no process listens on it. Errors: UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<Listener>> Listen(const Address& address);
  // Listens for connections of this process; those of other processes are closed. Errors:
  // UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<Listener>> ListenInternal();
  // Stops listening. Accepted connections stay open.
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  // The bound port; 0 for a unix socket.
  uint16_t port() const { return port_; }
  // The gRPC target of a listener made by ListenInternal; otherwise "".
  const std::string& internal_target() const { return internal_target_; }

  // Begins to accept in a separate thread, which calls `take`.
  void Start(Take take);

 private:
  Listener() = default;
  absl::Status ListenOnHost(const Address& address);
  absl::Status ListenOnPath(const std::string& path);
  absl::Status ListenOnAbstractName();
  absl::Status OpenStopPipe();
  void AcceptUntilStopped();
  void StopAccepting();
  // Accepts waiting connections, or some of them. False: no file descriptors are available.
  bool AcceptFrom(int listening);
  // Whether the peer may connect.
  bool IsAllowed(int connection) const;
  // Whether enough descriptors remain for other files.
  bool HasRoomFor(int connection);

  absl::Time next_warning_ = absl::InfinitePast();
  std::vector<int> sockets_;
  uint16_t port_ = 0;
  std::string path_;                        // of the unix socket; empty: none
  std::pair<dev_t, ino_t> path_file_ = {};  // its file, which another server may replace later
  std::string internal_target_;
  int stop_[2] = {-1, -1};  // ends of a pipe; readable: the thread stops
  Take take_;
  std::thread thread_;
};

}  // namespace procgen

#endif  // SERVER_NET_LISTENER_H_
