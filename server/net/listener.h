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
#include "server/net/address.h"
#include "server/net/connections.h"

namespace procgen {

// The sockets that a server listens on, the thread that accepts connections there, and one that has
// them inspected. gRPC's own listener stops for good once the process has run out of file
// descriptors, so any caller that opens enough connections would silence it. This one continues as
// soon as there are descriptors, and admits and inspects connections as Connections says.
// Threads: one at a time.
class Listener {
 public:
  // A connection that was accepted, and the socket by which it came; the connection is the taker's.
  using Take = std::function<void(int listening, int connection)>;

  // Listens, and accepts nothing yet. Port 0: any that is free. A file that is in the way of a
  // socket is removed if it is a socket that nobody listens on. Errors: UNAVAILABLE.
  // `connections`: takes in each, and says how many there may be.
  static absl::StatusOr<std::unique_ptr<Listener>> Listen(const Address& address,
                                                          std::shared_ptr<Connections> connections);
  // Listens where only this process can connect to; others are turned away. Errors: UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<Listener>> ListenWithin(
      std::shared_ptr<Connections> connections);
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
  explicit Listener(std::shared_ptr<Connections> connections)
      : connections_(std::move(connections)) {}
  absl::Status ListenOnHost(const Address& address);
  absl::Status ListenOnPath(const std::string& path);
  absl::Status ListenOnNewName();
  absl::Status MakeStop();
  void AcceptUntilStopped();
  // Apart from accepting: the thread that hands a connection to gRPC may have to parse what has
  // arrived on it.
  void InspectUntilStopped();
  void StopAccepting();
  // Accepts what waits at a socket, or some of it. False: there are no file descriptors.
  bool AcceptFrom(int listening);
  // Whether who connected may.
  bool IsWelcome(int connection) const;

  const std::shared_ptr<Connections> connections_;
  std::vector<int> sockets_;
  uint16_t port_ = 0;
  std::string path_;                        // of the socket's file, if it has one
  std::pair<dev_t, ino_t> path_file_ = {};  // the file: another server's may stand there later
  std::string target_within_;
  int stop_[2] = {-1, -1};  // the ends of a pipe; what can be read there stops the thread
  Take take_;
  std::thread thread_;
  int accepted_ = -1;  // an eventfd: readable after a connection was accepted
  std::thread inspecting_;
};

}  // namespace procgen

#endif  // SERVER_NET_LISTENER_H_
