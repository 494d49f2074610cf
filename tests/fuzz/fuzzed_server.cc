#include "tests/fuzz/fuzzed_server.h"

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "server/rpc/grpc/grpc_status.h"

namespace procgen {
namespace {

constexpr int kWorkerCount = 1;

Limits SmallLimits() {
  Limits limits;
  limits.pool_count_max = 4;
  limits.pool_env_count_max = 4;
  limits.env_count_max = 12;
  limits.observation_bytes_max = 1 << 20;
  limits.response_bytes_max = 1 << 20;
  limits.requests_in_flight_max = 4;
  return limits;
}

}  // namespace

FuzzedServer::FuzzedServer()
    : supervisor_(SmallLimits(), kWorkerCount, &metrics_),
      accounting_(Authenticator(nullptr, /*use_certificates=*/false), SmallLimits().attach_timeout,
                  &supervisor_.quotas(), &metrics_),
      services_(&supervisor_, cluster_.get(), &accounting_, /*pipe_listener=*/nullptr,
                CloneSourceAllowlist()) {
  // Over TCP, as real clients. gRPC's in-process transport keeps streams that ended while their
  // client wrote.
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  services_.RegisterWith(&builder);
  server_ = builder.BuildAndStart();
  Require(server_ != nullptr && port != 0, "there is a server");
  channel_ =
      grpc::CreateChannel(absl::StrCat("127.0.0.1:", port), grpc::InsecureChannelCredentials());
}

void FuzzedServer::ResetPools() {
  for (const PoolSupervisor::Numbered& listed : supervisor_.List("", 0, 100)) {
    Require(supervisor_.Delete("", listed.pool->name()).ok(),
            "a pool that is listed can be deleted");
  }
  for (const auto& [id, game, env_count, autoreset_mode, encoding] :
       {std::tuple("a", "maze", 2, AutoresetMode::kSameStep, Encoding::kRaw),
        std::tuple("b", "coinrun", 3, AutoresetMode::kDisabled, Encoding::kDeltaZstd)}) {
    PoolOptions options;
    options.games = {game};
    options.env_count = env_count;
    options.environment.distribution_mode = DistributionMode::kEasy;
    options.environment.rand_seed = 7;
    options.autoreset_mode = autoreset_mode;
    absl::Notification done;
    supervisor_.Create("", id, options, {.encoding = encoding},
                       [&done](const absl::StatusOr<std::shared_ptr<PoolSession>>& made) {
                         Require(made.ok(), "pools are created", made.status());
                         done.Notify();
                       });
    done.WaitForNotification();
  }
}

void FuzzedServer::RequireNoStreams() {
  const absl::Time end = absl::Now() + absl::Seconds(5);
  while (supervisor_.load().stream_count > 0) {
    Require(absl::Now() < end, "ended streams detach from their pools");
    absl::SleepFor(absl::Microseconds(50));
  }
}

FuzzedServer& TheFuzzedServer() {
  static FuzzedServer& server = *new FuzzedServer;
  return server;
}

void RequirePromised(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kAborted:
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kCancelled:
      break;
    default:
      Require(false, "errors have documented codes", status);
  }
  Require(status.message().size() <= kStatusMessageBytesMax, "messages fit", status);
}

}  // namespace procgen
