#ifndef PROCGEN_CLIENT_CLIENT_H_
#define PROCGEN_CLIENT_CLIENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "grpcpp/channel.h"
#include "grpcpp/support/channel_arguments.h"
#include "procgen/v1/catalog.grpc.pb.h"
#include "procgen/v1/cluster.grpc.pb.h"
#include "procgen/v1/pools.grpc.pb.h"
#include "procgen/v1/render.grpc.pb.h"
#include "procgen/v1/states.grpc.pb.h"
#include "procgen/v1/step.grpc.pb.h"
#include "procgen_client/batch.h"
#include "procgen_client/cancellation.h"
#include "procgen_client/credentials.h"
#include "procgen_client/internal/call_options.h"
#include "procgen_client/step_stream.h"
#include "procgen_client/watch.h"

namespace procgen_client {

struct ConnectOptions {
  // Time to wait for the server, which may still be starting. Absent: 10 s, or 1.5 s if nothing
  // listens at the address.
  std::optional<absl::Duration> timeout = std::nullopt;
  // Largest response that can be received, in bytes. Upper bound of
  // StreamOptions::response_bytes_max.
  int32_t response_bytes_max = 4 << 20;
  // Absent: Credentials::FromEnvironment().
  std::optional<Credentials> credentials = std::nullopt;
  // Idle time after which the client sends a keepalive ping, and time that the server has to answer
  // it. After that the connection counts as broken.
  absl::Duration keepalive_time = absl::Seconds(20);
  absl::Duration keepalive_timeout = absl::Seconds(10);
  // Deadline of each unary call, and of the first attach of a stream. DEADLINE_EXCEEDED after it.
  absl::Duration call_timeout = absl::InfiniteDuration();
  // Called every 50 ms on each thread that waits for the server, from connecting on. True: what it
  // waits for ends with CANCELLED, and a stream is over. Null: never. A Watch has Stop instead.
  CancellationCheck is_cancelled = nullptr;
  // Further arguments of the channel, for what has no option here.
  grpc::ChannelArguments channel_arguments = {};
};

// Source of CloneStates.
struct CloneSource {
  std::string pool;    // name of the pool; empty: that of the target pool
  std::string server;  // "host:port" as the target's server reaches it; empty: that server
};

// A connection to a server. Messages are those of the contract (proto/procgen/v1), whose comments
// tell their fields, errors and limits; the server's errors are returned as they are. An answer
// that does not fit its request is INTERNAL, whatever server sent it. Threads: any method from any
// thread.
class Client {
 public:
  // Connects to `address`, "host:port" or "unix:path". Errors: INVALID_ARGUMENT another form;
  // UNAVAILABLE no server listens or answers, or the TLS handshake fails; those of
  // ChannelCredentialsOf and Credentials::FromEnvironment.
  static absl::StatusOr<std::unique_ptr<Client>> Connect(const std::string& address,
                                                         const ConnectOptions& options = {});

  // Returns a client on an existing channel, e.g. one within a server's process. `token`: empty for
  // none; `call_timeout`: as in ConnectOptions.
  static std::unique_ptr<Client> FromChannel(
      const std::shared_ptr<grpc::Channel>& channel, std::string token,
      absl::Duration call_timeout = absl::InfiniteDuration());

  // Returns what the server offers.
  absl::StatusOr<procgen::v1::Catalog> GetCatalog();
  // Returns the current load of the server.
  absl::StatusOr<procgen::v1::Load> GetLoad();

  // Returns the servers of the cluster, or this server if it is in none.
  absl::StatusOr<procgen::v1::ListNodesResponse> ListNodes();
  // As ListNodes, and again after each change.
  std::unique_ptr<NodeWatch> WatchNodes();

  // Creates a pool. `pool_id`: last part of its name; empty: chosen by the server. The pool lives
  // until it is deleted or its lease (PoolSpec.lease_duration) expires.
  absl::StatusOr<procgen::v1::Pool> CreatePool(const procgen::v1::PoolSpec& spec,
                                               const std::string& pool_id = "");
  absl::StatusOr<procgen::v1::Pool> GetPool(const std::string& name);
  absl::StatusOr<std::vector<procgen::v1::Pool>> ListPools();
  absl::Status DeletePool(const std::string& name);
  // Restarts the lease of a pool. Absent `lease_duration`: its duration does not change.
  absl::StatusOr<procgen::v1::Pool> RenewPool(
      const std::string& name, std::optional<absl::Duration> lease_duration = std::nullopt);

  // Attaches a stream to a pool. The client must outlive the stream.
  absl::StatusOr<std::unique_ptr<StepStream>> Attach(const std::string& pool,
                                                     const StreamOptions& options = {});

  // Returns snapshots of `environments` in this order; empty: all. They are fetched in pages of at
  // most `response_bytes_max` bytes (0: 4 MiB). Errors: ABORTED environments were stepped, reset or
  // restored between two pages.
  absl::StatusOr<std::vector<procgen::v1::State>> SaveStates(
      const std::string& pool, absl::Span<const int32_t> environments = {},
      int64_t response_bytes_max = 0);
  // Restores snapshots. All or nothing if they fit in one request (Limits.request_bytes_max).
  // Otherwise several requests are sent, and those before an error stay restored.
  // StepStream::Observe returns the observations afterwards.
  absl::Status RestoreStates(const std::string& pool, absl::Span<const procgen::v1::State> states);
  // Copies states of environments of `source` to environments of `pool`. All or nothing.
  absl::Status CloneStates(const std::string& pool, absl::Span<const procgen::v1::ClonePair> pairs,
                           const CloneSource& source = {});

  // Returns an episode of an environment: the last that ended, or the current one.
  // procgen.v1.Episode documents how to replay it.
  absl::StatusOr<procgen::v1::Episode> GetEpisode(
      const std::string& pool, int32_t environment,
      procgen::v1::EpisodeSelector selector = procgen::v1::EPISODE_SELECTOR_LAST);
  // Returns an episode that ended, by its fingerprint, which is not 0. A server has those of a
  // pool's last 1,000 episodes, or fewer if they are long.
  absl::StatusOr<procgen::v1::Episode> FindEpisode(const std::string& pool, int32_t environment,
                                                   int64_t fingerprint);

  // Renders environments, or their whole levels (FRAME_VIEW_LEVEL), as square frames of `size_px`
  // pixels a side (0: 512, or 64 with FRAME_VIEW_AGENT): RGB with the top row first, or PNG files.
  absl::StatusOr<procgen::v1::RenderEnvironmentsResponse> RenderEnvironments(
      const std::string& pool, absl::Span<const int32_t> environments, int32_t size_px = 512,
      procgen::v1::FrameFormat format = procgen::v1::FRAME_FORMAT_RGB,
      procgen::v1::FrameView view = procgen::v1::FRAME_VIEW_HUMAN);
  // Streams frames of environments while a learner steps them. A request with a response_bytes_max
  // above 4 MiB needs the same in ConnectOptions::response_bytes_max.
  std::unique_ptr<PoolWatch> Watch(const procgen::v1::WatchPoolRequest& request);

 private:
  Client(const std::shared_ptr<grpc::Channel>& channel, CallOptions options);
  absl::Status AwaitConnection(grpc::Channel* channel, const std::string& address, bool uses_tls,
                               std::optional<absl::Duration> timeout);
  // Why there is no connection.
  std::string WhyNotConnected();
  absl::Status Restore(const procgen::v1::RestoreStatesRequest& request);
  absl::StatusOr<procgen::v1::Episode> EpisodeOf(const procgen::v1::GetEpisodeRequest& request);

  const CallOptions call_options_;
  const std::unique_ptr<procgen::v1::CatalogService::Stub> catalog_;
  const std::unique_ptr<procgen::v1::ClusterService::Stub> cluster_;
  const std::unique_ptr<procgen::v1::PoolService::Stub> pools_;
  const std::unique_ptr<procgen::v1::StepService::Stub> step_;
  const std::unique_ptr<procgen::v1::StateService::Stub> states_;
  const std::unique_ptr<procgen::v1::RenderService::Stub> render_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_CLIENT_H_
