#include "tests/fuzz/fuzzed_server.h"

#include <initializer_list>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/rpc/grpc/grpc_status.h"

namespace procgen {
namespace {

constexpr int kWorkerCount = 1;

Limits SmallLimits() {
  Limits limits;
  limits.env_count_max = 12;
  limits.owner_bytes_max = 64 << 20;
  limits.response_bytes_max = 1 << 20;
  return limits;
}

}  // namespace

FuzzedServer::FuzzedServer()
    : supervisor_(SmallLimits(), kWorkerCount, &metrics_),
      accounting_(Authenticator(nullptr, /*use_certificates=*/false), &supervisor_.quotas(),
                  &metrics_),
      catalog_service_(&supervisor_, &accounting_),
      cluster_service_(cluster_.get(), &accounting_),
      pool_service_(&supervisor_, &accounting_) {
  // Over TCP, as real clients. gRPC's in-process transport keeps streams that ended while their
  // client wrote.
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  for (grpc::Service* service : std::initializer_list<grpc::Service*>{
           &catalog_service_, &cluster_service_, &pool_service_}) {
    builder.RegisterService(service);
  }
  server_ = builder.BuildAndStart();
  Require(server_ != nullptr && port != 0, "there is a server");
  channel_ =
      grpc::CreateChannel(absl::StrCat("127.0.0.1:", port), grpc::InsecureChannelCredentials());
}

void FuzzedServer::RequirePoolCount(int32_t count) {
  const absl::Time end = absl::Now() + absl::Seconds(5);
  while (supervisor_.load().pool_count != count) {
    Require(absl::Now() < end, "pools end with their streams");
    absl::SleepFor(absl::Microseconds(50));
  }
}

FuzzedServer& TheFuzzedServer() {
  static FuzzedServer& server = *new FuzzedServer;
  return server;
}

LivePool::LivePool()
    : stub_(v1::PoolService::NewStub(TheFuzzedServer().channel())),
      stream_(stub_->RunPool(&context_)) {
  v1::RunPoolRequest request;
  request.mutable_start()->set_pool_id("a");
  v1::PoolSpec& spec = *request.mutable_start()->mutable_spec();
  spec.add_games("maze");
  spec.set_env_count(2);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec.mutable_options()->set_rand_seed(7);
  Require(Answer(request).has_started(), "a pool starts");
}

void LivePool::Step() {
  v1::RunPoolRequest request;
  request.mutable_step()->mutable_slice()->set_env_count(2);
  request.mutable_step()->add_actions(7);
  request.mutable_step()->add_actions(-1);
  Require(Answer(request).batch().rewards_size() == 2, "a pool steps");
}

v1::RunPoolResponse LivePool::Answer(const v1::RunPoolRequest& request) {
  v1::RunPoolResponse response;
  Require(stream_->Write(request) && stream_->Read(&response), "a pool answers");
  return response;
}

LivePool& TheLivePool() {
  static LivePool& pool = *new LivePool;
  return pool;
}

void RequirePromised(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kCancelled:
      break;
    default:
      Require(false, "errors have documented codes", status);
  }
  Require(status.message().size() <= kStatusMessageBytesMax, "messages fit", status);
}

}  // namespace procgen
