// Damaged responses between server and C++ client: the pool reports an error and writes nothing
// beyond the caller's memory.

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "gtest/gtest.h"
#include "procgen/v1/catalog.grpc.pb.h"
#include "procgen/v1/pool_service.grpc.pb.h"
#include "tests/clients/cpp/server_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

using Damage = std::function<void(v1::RunPoolResponse*)>;

// A proxy between a learner and a real server that changes one response of each RunPool.
// REQUIRES: each request is sent after the previous response.
class DamagingServer final : public v1::PoolService::Service, public v1::CatalogService::Service {
 public:
  // `number`: of the response, counted from 0 (started).
  DamagingServer(const std::shared_ptr<grpc::Channel>& target, int number, Damage damage)
      : pools_(v1::PoolService::NewStub(target)),
        catalog_(v1::CatalogService::NewStub(target)),
        number_(number),
        damage_(std::move(damage)) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(static_cast<v1::PoolService::Service*>(this));
    builder.RegisterService(static_cast<v1::CatalogService::Service*>(this));
    server_ = builder.BuildAndStart();
    address_ = absl::StrCat("127.0.0.1:", port);
  }

  const std::string& address() const { return address_; }

  grpc::Status GetCatalog(grpc::ServerContext* /*context*/, const v1::GetCatalogRequest* request,
                          v1::Catalog* catalog) override {
    grpc::ClientContext context;
    return catalog_->GetCatalog(&context, *request, catalog);
  }

  grpc::Status RunPool(
      grpc::ServerContext* /*context*/,
      grpc::ServerReaderWriter<v1::RunPoolResponse, v1::RunPoolRequest>* learner) override {
    grpc::ClientContext context;
    const auto stream = pools_->RunPool(&context);
    v1::RunPoolRequest request;
    v1::RunPoolResponse response;
    for (int number = 0;
         learner->Read(&request) && stream->Write(request) && stream->Read(&response); ++number) {
      if (number == number_) {
        damage_(&response);
      }
      learner->Write(response);
    }
    stream->WritesDone();
    return stream->Finish();
  }

 private:
  const std::unique_ptr<v1::PoolService::Stub> pools_;
  const std::unique_ptr<v1::CatalogService::Stub> catalog_;
  const int number_;
  const Damage damage_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
};

class DamagedResponsesTest : public ServerTest {
 protected:
  static constexpr int32_t kEnvCount = 4;

  void SetUp() override {
    ServerTest::SetUp();
    channel_ = grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
  }

  std::shared_ptr<grpc::Channel> channel_;
};

// AddressSanitizer checks that nothing else is written.
TEST_F(DamagedResponsesTest, DamagedBatchesAreErrors) {
  const Damage damages[] = {
      [](auto* r) { r->mutable_batch()->mutable_observations()->resize(10); },
      [](auto* r) { r->mutable_batch()->mutable_observations()->resize(1 << 20); },
      [](auto* r) { r->mutable_batch()->clear_observations(); },
      [](auto* r) { r->mutable_batch()->mutable_rewards()->Truncate(1); },
      [](auto* r) { r->mutable_batch()->mutable_rewards()->Resize(1000, 1); },
      [](auto* r) { r->mutable_batch()->mutable_terminated()->Resize(1000, true); },
      [](auto* r) { r->mutable_batch()->mutable_fingerprints()->Resize(1000, 1); },
      [](auto* r) { r->mutable_batch()->set_final_observations(std::string(1 << 20, 'x')); },
      [](auto* r) { r->mutable_batch()->set_first_env(1 << 30); },
      [](auto* r) { r->mutable_batch()->set_env_count(-1); },
      [](auto* r) { r->mutable_ack(); },
      [](auto* r) { r->Clear(); },
  };
  for (const Damage& damage : damages) {
    const DamagingServer between(channel_, 2, damage);
    const auto pool = CreatePool(MazeOptions(kEnvCount), {}, between.address());
    const std::vector<int32_t> ends(kEnvCount, -1);
    Memory memory(kEnvCount);
    std::vector<uint8_t> finals(memory.observations.size());
    Batch batch = memory.batch();
    batch.final_observations = absl::MakeSpan(finals);
    EXPECT_THAT(pool->Step({.count = kEnvCount, .actions = ends}, {}, batch), IsOk());
    for (int i = 0; i < 2; ++i) {
      EXPECT_THAT(pool->Step({.count = kEnvCount, .actions = ends}, {}, batch),
                  StatusIs(absl::StatusCode::kDataLoss, HasSubstr("malformed")));
    }
  }
}

TEST_F(DamagedResponsesTest, DamagedEncodedObservationsAreErrors) {
  for (const int32_t bytes : {0, 10, 1 << 20}) {
    const DamagingServer between(channel_, 1, [bytes](auto* response) {
      response->mutable_batch()->mutable_observations()->resize(static_cast<size_t>(bytes));
    });
    procgen_client::RemotePoolOptions remote;
    remote.encoding = v1::ENCODING_DELTA_ZSTD;
    const auto pool = CreatePool(MazeOptions(kEnvCount), remote, between.address());
    Memory memory(kEnvCount);
    EXPECT_THAT(pool->Step({.count = kEnvCount, .steps = false}, {}, memory.batch()),
                StatusIs(absl::StatusCode::kDataLoss, testing::_));
  }
}

TEST_F(DamagedResponsesTest, PoolsOfAnotherSizeAreErrors) {
  const Damage damages[] = {
      [](auto* r) { r->mutable_started()->mutable_pool()->mutable_spec()->set_env_count(1 << 30); },
      [](auto* r) { r->mutable_started()->mutable_pool()->set_observation_bytes(0); },
      [](auto* r) { r->mutable_ack(); },
  };
  for (const Damage& damage : damages) {
    const DamagingServer between(channel_, 0, damage);
    const auto servers = procgen_client::Servers::Connect(between.address());
    ASSERT_THAT(servers, IsOk());
    EXPECT_FALSE(procgen_client::CreatePool(*servers, MazeOptions(kEnvCount)).ok());
  }
}

TEST_F(DamagedResponsesTest, AServerThatIgnoresTheVariantIsAnError) {
  const DamagingServer between(channel_, 0, [](auto* response) {
    v1::PoolSpec* spec = response->mutable_started()->mutable_pool()->mutable_spec();
    EXPECT_EQ(spec->options().variant(), "cheese_corner");
    spec->mutable_options()->clear_variant();
  });
  const auto servers = procgen_client::Servers::Connect(between.address());
  ASSERT_THAT(servers, IsOk());
  PoolOptions options = MazeOptions(kEnvCount);
  options.environment.variant = Variant::kCheeseCorner;
  EXPECT_THAT(procgen_client::CreatePool(*servers, options).status(),
              StatusIs(absl::StatusCode::kUnimplemented,
                       HasSubstr(R"(variant is "cheese_corner", the server plays "")")));
}

TEST_F(DamagedResponsesTest, FramesOfAnotherSizeAreErrors) {
  const Damage damages[] = {
      [](auto* r) { r->mutable_frames()->mutable_frames(0)->mutable_image()->push_back('x'); },
      [](auto* r) { r->mutable_frames()->clear_frames(); },
      [](auto* r) { r->mutable_ack(); },
  };
  for (const Damage& damage : damages) {
    const DamagingServer between(channel_, 1, damage);
    const auto pool = CreatePool(MazeOptions(kEnvCount), {}, between.address());
    std::vector<uint8_t> frame(64 * 64 * 3);
    EXPECT_THAT(pool->Render(0, 64, /*whole_level=*/false, absl::MakeSpan(frame)),
                StatusIs(absl::StatusCode::kInternal, testing::_));
    EXPECT_THAT(pool->Render(0, 64, /*whole_level=*/false, absl::MakeSpan(frame)), IsOk());
  }
}

}  // namespace
}  // namespace procgen
