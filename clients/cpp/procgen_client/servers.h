#ifndef PROCGEN_CLIENT_SERVERS_H_
#define PROCGEN_CLIENT_SERVERS_H_

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "procgen_client/client.h"
#include "procgen_client/pool.h"
#include "procgen_client/remote_pool.h"

namespace procgen_client {

// The servers that pools can run on. Threads: any method from any thread.
class Servers {
 public:
  // Connects to `addresses`, separated by commas, of which one must answer:
  //   host:port          the server there; if the name has several IPv4 addresses, one at each
  //   unix:path          the server at this socket
  //   cluster:host:port  all servers of the cluster of the server there, also those that join later
  // Connections to several servers have a keepalive time of a second. Errors: those of
  // Client::Connect.
  static absl::StatusOr<std::shared_ptr<Servers>> Connect(absl::string_view addresses,
                                                          ConnectOptions options = {});
  Servers(const Servers&) = delete;
  Servers& operator=(const Servers&) = delete;

  // One that has answered.
  const std::shared_ptr<Client>& first() const { return first_; }
  // Whether there is and will be only that one.
  bool is_single() const { return is_single_; }
  // All that are known.
  std::vector<std::shared_ptr<Client>> All() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Asks clusters for their members again, unless it just did: one server after
  // another, for at most half a second each. `with_names`: also looks names up that had several
  // addresses, which may take seconds.
  void Refresh(bool with_names) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  Servers(std::vector<std::string> given, ConnectOptions options)
      : given_(std::move(given)), options_(std::move(options)) {}

  // Connects to the members of the cluster of the server at `address`, or of one that is known.
  void RefreshCluster(const std::string& address) ABSL_LOCKS_EXCLUDED(mutex_);
  // Connects to the servers at the addresses of a name.
  void RefreshName(const std::string& given) ABSL_LOCKS_EXCLUDED(mutex_);
  // Connects to a server unless it is known. `tls_name`: the name in its certificate, if that is
  // not its host.
  absl::Status Add(const std::string& address, const std::string& tls_name = "")
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Waits until one answers.
  absl::Status AwaitFirst();

  const std::vector<std::string> given_;
  ConnectOptions options_;
  std::shared_ptr<Client> first_;
  bool is_single_ = false;

  mutable absl::Mutex mutex_;
  std::vector<std::shared_ptr<Client>> clients_ ABSL_GUARDED_BY(mutex_);  // in order of discovery
  std::map<std::string, std::shared_ptr<Client>> by_address_ ABSL_GUARDED_BY(mutex_);
  absl::Time refresh_time_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();  // of the last one
};

// The server that a pool runs on. Threads: one at a time.
class PoolPlace {
 public:
  // `servers` null: only `home`.
  PoolPlace(std::shared_ptr<Servers> servers, std::shared_ptr<Client> home)
      : servers_(std::move(servers)), home_(std::move(home)), current_(home_) {}

  // The server of the next call, as OpenRunStream. After its connection broke, a server is called
  // again once; then it is the next one's turn. When all had theirs, names are looked up again.
  Client* Next(int attempt);
  // Whether the pool is elsewhere and its home is back, where the next call is then.
  bool IsHomeBack();

 private:
  const std::shared_ptr<Servers> servers_;
  const std::shared_ptr<Client> home_;
  std::shared_ptr<Client> current_;
};

// Creates a pool: on the server, or spread over several (ShardedPool). Errors: those of
// RemotePool::Create.
procgen::StatusOr<std::unique_ptr<Pool>> CreatePool(const std::shared_ptr<Servers>& servers,
                                                    const procgen::PoolOptions& options,
                                                    const RemotePoolOptions& remote = {});

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_SERVERS_H_
