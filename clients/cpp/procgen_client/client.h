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
#include "procgen_client/call_options.h"
#include "procgen_client/cancellation.h"
#include "procgen_client/credentials.h"
#include "procgen_client/step_stream.h"
#include "procgen_client/watch.h"

namespace procgen_client {

struct ConnectOptions {
  absl::Duration timeout = absl::Seconds(10);  // until the server must have answered
  // Largest response that can be received, in bytes. StreamOptions::response_bytes_max may be as
  // much.
  int32_t response_bytes_max = 4 << 20;
  // None: Credentials::FromEnvironment().
  std::optional<Credentials> credentials = std::nullopt;
  // A connection on which nothing arrived for `keepalive_time` is asked for a sign of life, and is
  // broken if there is none within `keepalive_timeout`.
  absl::Duration keepalive_time = absl::Seconds(20);
  absl::Duration keepalive_timeout = absl::Seconds(10);
  // How long each call may take, of a stream its first attach; then it is DEADLINE_EXCEEDED.
  absl::Duration call_timeout = absl::InfiniteDuration();
  // Called every 50 ms on each thread that waits for the server, from connecting on. True: what it
  // waits for ends with CANCELLED, and a stream is over. Null: never. A Watch has Stop instead.
  CancellationCheck is_cancelled = nullptr;
  // Further arguments of the channel, for what has no option here.
  grpc::ChannelArguments channel_arguments = {};
};

// Where CloneStates reads.
struct CloneSource {
  std::string pool;    // its name; empty: that of the pool that is written
  std::string server;  // "host:port" as the server that is asked can reach it; empty: itself
};

// A connection to a server. Messages are those of the contract (proto/procgen/v1), whose comments
// tell their fields, errors and limits; the server's errors are returned as they are. An answer
// that does not fit its request is INTERNAL, whatever server sent it. Threads: any method from any
// thread.
class Client {
 public:
  // Connects to `address`, "host:port" or "unix:path". Errors: UNAVAILABLE nobody answers,
  // or not in TLS as it should; those of ChannelCredentialsOf and Credentials::FromEnvironment.
  static absl::StatusOr<std::unique_ptr<Client>> Connect(const std::string& address,
                                                         const ConnectOptions& options = {});

  // A client on a channel that there is, such as one within a server's own process; `token`: empty,
  // none; `call_timeout`: as in ConnectOptions.
  static std::unique_ptr<Client> FromChannel(
      const std::shared_ptr<grpc::Channel>& channel, std::string token,
      absl::Duration call_timeout = absl::InfiniteDuration());

  // What the server offers, and how busy it is.
  absl::StatusOr<procgen::v1::Catalog> GetCatalog();
  absl::StatusOr<procgen::v1::Load> GetLoad();

  // The servers of its cluster, or it alone: now, and again when that changes.
  absl::StatusOr<procgen::v1::ListNodesResponse> ListNodes();
  std::unique_ptr<NodeWatch> WatchNodes();

  // Makes a pool. `pool_id`: last part of its name; empty: chosen by the server. A pool lives until
  // it is deleted or its lease (PoolSpec.lease_duration) runs out.
  absl::StatusOr<procgen::v1::Pool> CreatePool(const procgen::v1::PoolSpec& spec,
                                               const std::string& pool_id = "");
  absl::StatusOr<procgen::v1::Pool> GetPool(const std::string& name);
  absl::StatusOr<std::vector<procgen::v1::Pool>> ListPools();
  absl::Status DeletePool(const std::string& name);
  // Begins the pool's lease anew, of another length if one is given.
  absl::StatusOr<procgen::v1::Pool> RenewPool(
      const std::string& name, std::optional<absl::Duration> lease_duration = std::nullopt);

  // Takes a pool to step it.
  absl::StatusOr<std::unique_ptr<StepStream>> Attach(const std::string& pool,
                                                     const StreamOptions& options = {});

  // Snapshots of environments, in the order asked for; of all, if none is named. Many are fetched
  // page by page. Errors: ABORTED environments were stepped, reset or restored between two pages.
  // `response_bytes_max`: of a page, as StreamOptions has it.
  absl::StatusOr<std::vector<procgen::v1::State>> SaveStates(
      const std::string& pool, absl::Span<const int32_t> environments = {},
      int64_t response_bytes_max = 0);
  // Puts environments into saved states. All or nothing, if they fit one request of the server
  // (Limits.request_bytes_max); otherwise several are sent, and those before an error are restored.
  // A stream tells by StepStream::Observe how the environments stand then.
  absl::Status RestoreStates(const std::string& pool, absl::Span<const procgen::v1::State> states);
  // Puts environments of `pool` into the states of others. All or nothing.
  absl::Status CloneStates(const std::string& pool, absl::Span<const procgen::v1::ClonePair> pairs,
                           const CloneSource& source = {});

  // What happened in an episode of an environment: the last that ended, or the one under way. Its
  // comments tell how to play it again.
  absl::StatusOr<procgen::v1::Episode> GetEpisode(
      const std::string& pool, int32_t environment,
      procgen::v1::EpisodeSelector selector = procgen::v1::EPISODE_SELECTOR_LAST);

  // Draws environments for people, or (size_px 0) as agents see them: square frames, RGB with the
  // top row first, or PNG files.
  absl::StatusOr<procgen::v1::RenderEnvironmentsResponse> RenderEnvironments(
      const std::string& pool, absl::Span<const int32_t> environments, int32_t size_px = 512,
      procgen::v1::FrameFormat format = procgen::v1::FRAME_FORMAT_RGB,
      procgen::v1::FrameView view = procgen::v1::FRAME_VIEW_HUMAN);
  // Watches environments while somebody steps them: Next waits for the next frames. Who asks for
  // more bytes in a response than 4 MiB needs as many in ConnectOptions::response_bytes_max.
  std::unique_ptr<PoolWatch> Watch(const procgen::v1::WatchPoolRequest& request);

 private:
  Client(const std::shared_ptr<grpc::Channel>& channel, CallOptions terms);
  absl::Status AwaitConnection(grpc::Channel* channel, const std::string& address,
                               absl::Duration timeout);
  // Why there is no connection.
  std::string WhyNotConnected();
  absl::Status Restore(const procgen::v1::RestoreStatesRequest& request);

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
