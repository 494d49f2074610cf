#ifndef SERVER_RPC_LISTENER_H_
#define SERVER_RPC_LISTENER_H_

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/rpc/address.h"

namespace procgen {

// The sockets that a server listens on, and the thread that accepts connections there. gRPC's own
// listens no more, for good, once the process has run out of file descriptors; so whoever opens
// enough connections would silence it. This one goes on as soon as there are descriptors, and lets
// no more connections in than it is told to.
// Threads: one at a time.
class Listener {
 public:
  // A connection that was accepted, and the socket by which it came; the connection is the taker's.
  using Take = std::function<void(int listening, int connection)>;

  // Listens, and accepts nothing yet. Port 0: any that is free. A file that is in the way of a
  // socket is removed if it is a socket that nobody listens on. Errors: UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<Listener>> Listen(const Address& address,
                                                          int32_t connection_count_max);
  // Listens where only this process can connect to; others are turned away. Errors: UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<Listener>> ListenWithin(int32_t connection_count_max);
  // Listens no more. Connections that were taken stay.
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  // The port that was bound; 0 for a socket in the file system.
  uint16_t port() const { return port_; }
  // What connects to one that listens within the process, as gRPC takes it; of others "".
  const std::string& target_within() const { return target_within_; }

  // Begins to accept, in a thread of its own, and hands over to `take` there.
  void Start(Take take);

  // Accepts no more, and breaks the connections that were taken: at their other ends the network
  // has failed, or the process was killed.
  void HangUp();

 private:
  explicit Listener(int32_t connection_count_max)
      : connection_count_max_(static_cast<size_t>(connection_count_max)) {}
  absl::Status ListenOnHost(const Address& address);
  absl::Status ListenOnPath(const std::string& path);
  absl::Status ListenOnNewName();
  absl::Status MakeStop();
  void AcceptUntilStopped();
  void StopAccepting();
  // Accepts what waits at a socket, or some of it. False: there are no file descriptors.
  bool AcceptFrom(int listening);
  // Whether one more connection may be had.
  bool HasRoom();
  // Whether who connected may.
  bool IsWelcome(int connection) const;

  const size_t connection_count_max_;
  std::vector<int> sockets_;
  uint16_t port_ = 0;
  std::string path_;                        // of the socket's file, if it has one
  std::pair<dev_t, ino_t> path_file_ = {};  // the file: another server's may stand there later
  std::string target_within_;
  int stop_[2] = {-1, -1};  // the ends of a pipe; what can be read there stops the thread
  Take take_;
  std::thread thread_;
  // Connections that were handed over, with their inodes. Those that were closed since are found
  // when there is no room: the descriptor is gone, or another file's.
  std::unordered_map<int, ino_t> connections_;
  bool is_full_ = false;  // and the log has told it
};

}  // namespace procgen

#endif  // SERVER_RPC_LISTENER_H_
