#ifndef PROCGEN_CLIENT_CLIENT_H_
#define PROCGEN_CLIENT_CLIENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "google/protobuf/message_lite.h"
#include "grpcpp/channel.h"
#include "grpcpp/support/channel_arguments.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/cluster.pb.h"
#include "procgen/v1/pool_service.pb.h"
#include "procgen_client/credentials.h"
#include "procgen_client/internal/call_options.h"
#include "procgen_client/message_watch.h"
#include "procgen_client/open_calls.h"
#include "procgen_client/run/grpc_run_stream.h"
#include "procgen_client/watch.h"

namespace procgen_client {

struct ConnectOptions {
  // Time to wait for the server, which may still be starting. Absent: 10 s, or 1.5 s if nothing
  // listens at the address.
  std::optional<absl::Duration> timeout = std::nullopt;
  // False: Connect does not wait for the server; calls do, or fail.
  bool waits_for_server = true;
  // Absent: Credentials::FromEnvironment().
  std::optional<Credentials> credentials = std::nullopt;
  // Idle time after which the client sends a keepalive ping, and time that the server has to answer
  // it. After that the connection counts as broken.
  absl::Duration keepalive_time = absl::Seconds(20);
  absl::Duration keepalive_timeout = absl::Seconds(10);
  // Deadline of each unary call. DEADLINE_EXCEEDED after it.
  absl::Duration call_timeout = absl::InfiniteDuration();
  // Ends calls and pools. Null: of this connection only.
  std::shared_ptr<OpenCalls> calls = nullptr;
  // Further arguments of the channel, for what has no option here.
  grpc::ChannelArguments channel_arguments = {};
};

// A connection to a server. Messages are those of the contract (proto/procgen/v1), whose comments
// tell their fields, errors and limits; the server's errors are returned as they are. Threads: any
// method from any thread.
class Client {
 public:
  // Connects to `address`, "host:port" or "unix:path". Errors: INVALID_ARGUMENT another form;
  // UNAVAILABLE no server listens or answers, or the TLS handshake fails; those of
  // ChannelCredentialsOf and Credentials::FromEnvironment.
  static absl::StatusOr<std::unique_ptr<Client>> Connect(const std::string& address,
                                                         const ConnectOptions& options = {});

  // Returns what the server offers.
  absl::StatusOr<procgen::v1::Catalog> GetCatalog();
  // Returns the current load of the server.
  absl::StatusOr<procgen::v1::Load> GetLoad();

  // Returns the servers of the cluster, or this server if it is in none.
  absl::StatusOr<procgen::v1::ListNodesResponse> ListNodes();

  // Returns a pool, or all that the caller may see.
  absl::StatusOr<procgen::v1::Pool> GetPool(const std::string& name);
  absl::StatusOr<std::vector<procgen::v1::Pool>> ListPools();

  // Returns an episode of an environment: the last that ended, or the current one.
  // procgen.v1.Episode documents how to replay it.
  absl::StatusOr<procgen::v1::Episode> GetEpisode(
      const std::string& pool, int32_t environment,
      procgen::v1::EpisodeSelector selector = procgen::v1::EPISODE_SELECTOR_LAST);
  // Returns an episode that ended, by its fingerprint, which is not 0. A server has those of a
  // pool's last 1,000 episodes, or fewer if they are long.
  absl::StatusOr<procgen::v1::Episode> FindEpisode(const std::string& pool, int32_t environment,
                                                   int64_t fingerprint);

  // Streams frames of environments while a learner steps them.
  std::unique_ptr<PoolWatch> Watch(const procgen::v1::WatchPoolRequest& request);

  // Calls a unary method by its path, "/procgen.v1.PoolService/GetPool", with serialised messages.
  // The response is not validated. `timeout` absent: ConnectOptions::call_timeout.
  absl::StatusOr<std::string> Call(const std::string& path, absl::string_view request,
                                   std::optional<absl::Duration> timeout = std::nullopt) const;
  // Whether there is a connection now; begins to make one otherwise. Does not block.
  bool is_connected() const {
    return channel_->GetState(/*try_to_connect=*/true) == GRPC_CHANNEL_READY;
  }
  // The open calls of this connection.
  const std::shared_ptr<OpenCalls>& calls() const { return call_options_.calls; }
  // Begins a call of RunPool. `events`: shared by calls of one thread.
  std::unique_ptr<RunStream> OpenRunPool(const std::shared_ptr<EventQueue>& events);
  // Calls a method with a stream of responses by its path, with serialised messages.
  std::unique_ptr<MessageWatch> WatchMessages(const std::string& path, absl::string_view request);

 private:
  Client(std::shared_ptr<grpc::Channel> channel, CallOptions options);
  absl::Status AwaitConnection(grpc::Channel* channel, const std::string& address, bool uses_tls,
                               std::optional<absl::Duration> timeout);
  // Why there is no connection.
  std::string WhyNotConnected() const;
  // Calls a unary method with messages. Errors also: INTERNAL a malformed response.
  template <typename Response>
  absl::StatusOr<Response> CallUnary(const std::string& path,
                                     const google::protobuf::MessageLite& request);
  absl::StatusOr<procgen::v1::Episode> EpisodeOf(const procgen::v1::GetEpisodeRequest& request);

  const CallOptions call_options_;
  const std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_CLIENT_H_
