// Damaged responses between server and C++ client: the stream reports an error, and none of the
// response's arrays can be read.

#include <functional>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "grpcpp/generic/async_generic_service.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/robustness/damaging_server.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/shared_memory_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class DamagedAnswersTest : public ServiceTest {};
class DamagedSharedAnswersTest : public SharedMemoryTest {};

TEST_F(DamagedAnswersTest, DamagedResponsesAreNotRead) {
  const std::pair<DamagingServer::Damage, std::string> cases[] = {
      {[](auto* r) { r->mutable_batch()->mutable_observations()->resize(10); },
       "request 2: observations of size 10, expected: 49152"},
      {[](auto* r) { r->mutable_batch()->mutable_rewards()->Truncate(1); },
       "request 2: rewards of size 1, expected: 4"},
      {[](auto* r) { r->mutable_batch()->mutable_fingerprints()->Truncate(1); },
       "request 2: fingerprints of size 1, expected: 4"},
      {[](auto* r) { r->mutable_batch()->set_first_env(1 << 30); },
       "4 environments from 1073741824, expected: 1 to 4 from 0"},
      {[](auto* r) { r->mutable_batch()->set_env_count(-1); }, "-1 environments from 0"},
      {[](auto* r) { r->mutable_ack(); }, "a response of kind 3, expected: 4"},
      {[](auto* r) { r->clear_batch(); }, "a response of kind 0, expected: 4"},
      {[](auto* r) { r->set_sequence_number(1); }, "number 1, expected: 2"},
  };
  for (const auto& [damage, message] : cases) {
    const std::string pool = CreatePool(MazeSpec(4));
    DamagingServer between(channel_, 2, damage);
    const auto client = procgen_client::Client::Connect(between.address());
    ASSERT_THAT(client, IsOk());
    const auto stream = (*client)->Attach(pool);
    ASSERT_THAT(stream, IsOk());
    procgen_client::Batch batch;
    ASSERT_THAT((*stream)->Step({4, 4, 4, 4}, &batch), IsOk());
    EXPECT_THAT((*stream)->Step({-1, -1, -1, -1}, &batch),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)));
    EXPECT_EQ(batch.env_count(), 0);
    EXPECT_THAT(batch.rewards(), IsEmpty());
    EXPECT_THAT(batch.observations(), IsEmpty());
    EXPECT_THAT((*stream)->Observe(&batch),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)));
    EXPECT_THAT(client_->DeletePool(pool), IsOk());
  }
}

TEST_F(DamagedAnswersTest, DamagedAttachResponsesAreRejected) {
  const std::string pool = CreatePool(MazeSpec(4));
  const std::pair<DamagingServer::Damage, std::string> cases[] = {
      {[](auto* r) { r->mutable_ack(); }, "the server's first response does not answer attach"},
      {[](auto* r) { r->mutable_attached()->clear_pool(); }, "pool '', expected: 'pools/"},
      {[](auto* r) {
         r->mutable_attached()->mutable_pool()->mutable_spec()->set_env_count(INT32_MAX);
       },
       "a pool of 2147483647 environments"},
      {[](auto* r) { r->mutable_attached()->mutable_pool()->set_observation_bytes(0); },
       "observations of 0 bytes"},
  };
  for (const auto& [damage, message] : cases) {
    DamagingServer between(channel_, 0, damage);
    const auto client = procgen_client::Client::Connect(between.address());
    ASSERT_THAT(client, IsOk());
    EXPECT_THAT((*client)->Attach(pool, {.take_over = true}),
                StatusIs(absl::StatusCode::kInternal, HasSubstr(message)));
  }
}

TEST_F(DamagedAnswersTest, ClaimedEnvironmentsTakeNoMemory) {
  v1::PoolSpec spec = MazeSpec(4);
  spec.set_encoding(v1::ENCODING_DELTA_ZSTD);
  DamagingServer between(channel_, 0, [](auto* response) {
    // The decoder stores one observation per environment: 192 GiB here.
    response->mutable_attached()->mutable_pool()->mutable_spec()->set_env_count(1 << 24);
  });
  const auto client = procgen_client::Client::Connect(between.address());
  ASSERT_THAT(client, IsOk());
  const auto stream = (*client)->Attach(CreatePool(spec));
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Observe(&batch),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("as the last, expected: up to")));
}

TEST_F(DamagedAnswersTest, UnknownResponseKindsAreIgnored) {
  const std::string pool = CreatePool(MazeSpec(2));
  // A response kind that this client does not know precedes the response to request 2.
  class Talkative final : public v1::StepService::Service {
   public:
    explicit Talkative(const std::shared_ptr<grpc::Channel>& target)
        : target_(v1::StepService::NewStub(target)) {}
    grpc::Status StepPool(
        grpc::ServerContext* /*context*/,
        grpc::ServerReaderWriter<v1::StepPoolResponse, v1::StepPoolRequest>* learner) override {
      grpc::ClientContext context;
      const auto stream = target_->StepPool(&context);
      v1::StepPoolRequest request;
      v1::StepPoolResponse response;
      while (learner->Read(&request) && stream->Write(request) && stream->Read(&response)) {
        if (response.has_batch()) {
          learner->Write(v1::StepPoolResponse());
        }
        learner->Write(response);
      }
      stream->WritesDone();
      return stream->Finish();
    }

   private:
    const std::unique_ptr<v1::StepService::Stub> target_;
  };
  Talkative talkative(channel_);
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&talkative);
  const auto server = builder.BuildAndStart();
  const auto client = procgen_client::Client::Connect(absl::StrCat("127.0.0.1:", port));
  ASSERT_THAT(client, IsOk());
  const auto stream = (*client)->Attach(pool);
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  for (int64_t number = 1; number <= 3; ++number) {
    ASSERT_THAT((*stream)->Step({4, 4}, &batch), IsOk());
    EXPECT_EQ(batch.sequence_number(), number);
    EXPECT_EQ(batch.env_count(), 2);
  }
}

// A server that answers any call with an unparsable response and does not end it.
class Mumbler final : public grpc::CallbackGenericService {
 public:
  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* /*context*/) override {
    class Mumble final : public grpc::ServerGenericBidiReactor {
     public:
      Mumble() { StartWrite(&response_); }
      void OnCancel() override { Finish(grpc::Status::CANCELLED); }
      void OnDone() override { delete this; }

     private:
      const grpc::Slice bytes_{"\xff"};
      const grpc::ByteBuffer response_{&bytes_, 1};
    };
    return new Mumble;
  }
};

TEST_F(DamagedAnswersTest, WatchEndsAfterInvalidMessages) {
  Mumbler mumbler;
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterCallbackGenericService(&mumbler);
  const auto server = builder.BuildAndStart();
  const auto client = procgen_client::Client::FromChannel(
      grpc::CreateChannel(absl::StrCat("127.0.0.1:", port), grpc::InsecureChannelCredentials()),
      "");
  const auto watch = client->Watch({});
  EXPECT_THAT(watch->Next(), StatusIs(absl::StatusCode::kDataLoss, HasSubstr("is malformed")));
}

// A proxy that breaks the learner's first stream at its first request, after it called `meanwhile`.
class BreakingServer final : public v1::StepService::Service {
 public:
  BreakingServer(const std::shared_ptr<grpc::Channel>& target, std::function<void()> meanwhile)
      : target_(v1::StepService::NewStub(target)), meanwhile_(std::move(meanwhile)) {}

  grpc::Status StepPool(
      grpc::ServerContext* /*context*/,
      grpc::ServerReaderWriter<v1::StepPoolResponse, v1::StepPoolRequest>* learner) override {
    grpc::ClientContext context;
    const auto stream = target_->StepPool(&context);
    v1::StepPoolRequest request;
    v1::StepPoolResponse response;
    while (learner->Read(&request)) {
      if (meanwhile_ != nullptr && !request.has_attach()) {
        context.TryCancel();
        stream->Finish();
        std::exchange(meanwhile_, nullptr)();
        return {grpc::StatusCode::UNAVAILABLE, "broken"};
      }
      stream->Write(request);
      stream->Read(&response);
      learner->Write(response);
    }
    stream->WritesDone();
    return stream->Finish();
  }

 private:
  const std::unique_ptr<v1::StepService::Stub> target_;
  std::function<void()> meanwhile_;
};

TEST_F(DamagedSharedAnswersTest, ReattachedLearnerMapsBatchesOfTheEarlierStream) {
  const std::string pool = CreatePool(SharedSpec(MazeSpec(1)));
  BreakingServer between(
      grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()), [&] {
        const auto another = Attach(pool, {.take_over = true, .held_batches_max = 9});
        EXPECT_THAT(another->Close(), IsOk());
      });
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&between);
  const auto server = builder.BuildAndStart();
  const auto client = procgen_client::Client::Connect(absl::StrCat("127.0.0.1:", port));
  ASSERT_THAT(client, IsOk());
  const auto stream = (*client)->Attach(
      pool, {.requests_in_flight_max = 1, .held_batches_max = 1, .pipe_transport = false});
  ASSERT_THAT(stream, IsOk());
  std::vector<procgen_client::Batch> held(8);  // two slots at first, then eleven
  for (procgen_client::Batch& batch : held) {
    ASSERT_THAT((*stream)->Step({4}, &batch), IsOk());
  }
  for (size_t i = 0; i < held.size(); ++i) {
    EXPECT_THAT(held[i].episode_lengths(), testing::ElementsAre(static_cast<int32_t>(i) + 1));
  }
}

TEST_F(DamagedSharedAnswersTest, UnknownBatchesAreNotRead) {
  const auto channel = grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
  const std::pair<DamagingServer::Damage, std::string> cases[] = {
      {[](auto* r) { r->mutable_batch()->set_shared_batch(4); },
       "batch 4 of shared memory, expected: 0 to 3"},
      {[](auto* r) { r->mutable_batch()->set_shared_batch(-1); }, "batch -1 of shared memory"},
      {[](auto* r) { r->mutable_batch()->set_shared_batch(0); },
       "batch 0 of shared memory, expected: one that is not held"},
      {[](auto* r) { r->mutable_batch()->clear_shared_batch(); }, "no batch of shared memory"},
      {[](auto* r) { r->mutable_batch()->set_env_count(1 << 30); },
       "1073741824 environments from 0"},
  };
  for (const auto& [damage, message] : cases) {
    const std::string pool = CreatePool(SharedSpec(MazeSpec(2)));
    DamagingServer between(channel, 2, damage);
    const auto client = procgen_client::Client::Connect(between.address());
    ASSERT_THAT(client, IsOk());
    const auto stream = (*client)->Attach(pool, {.pipe_transport = false});
    ASSERT_THAT(stream, IsOk());
    procgen_client::Batch first;
    ASSERT_THAT((*stream)->Step({4, 4}, &first), IsOk());
    procgen_client::Batch batch;
    EXPECT_THAT((*stream)->Step({4, 4}, &batch),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)));
    EXPECT_THAT(batch.rewards(), IsEmpty());
    EXPECT_EQ(first.rewards().size(), 2);  // the batch is still held
  }
}

TEST_F(DamagedSharedAnswersTest, MismatchedMemoryIsNotMapped) {
  const auto channel = grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
  const std::string pool = CreatePool(SharedSpec(MazeSpec(2)));
  const auto memory = [](auto* response) {
    return response->mutable_attached()->mutable_shared_memory();
  };
  const std::tuple<DamagingServer::Damage, absl::StatusCode, std::string> cases[] = {
      {[&](auto* r) { memory(r)->set_size_bytes(INT64_MAX); }, absl::StatusCode::kInternal,
       "has 9223372036854775807 bytes"},
      {[&](auto* r) { memory(r)->set_batch_count(0); }, absl::StatusCode::kInternal, "0 x "},
      {[&](auto* r) {
         memory(r)->set_batch_count(4096);
         memory(r)->set_size_bytes(4096 * memory(r)->batch_bytes());
       },
       absl::StatusCode::kFailedPrecondition, "and is shorter than"},
      {[&](auto* r) { memory(r)->mutable_arrays(3)->set_offset_bytes(1 << 30); },
       absl::StatusCode::kInternal, "at 1073741824, expected: a multiple of 64 up to "},
      {[&](auto* r) { memory(r)->mutable_arrays(3)->set_offset_bytes(-64); },
       absl::StatusCode::kInternal, "at -64, expected"},
      {[&](auto* r) { memory(r)->mutable_arrays(3)->set_shape(0, 1); }, absl::StatusCode::kInternal,
       "of another type or shape, expected: 2 rows of"},
      {[&](auto* r) { memory(r)->mutable_arrays(3)->add_shape(2); }, absl::StatusCode::kInternal,
       "of another type or shape"},
      {[&](auto* r) { memory(r)->clear_arrays(); }, absl::StatusCode::kInternal, "has no array"},
      {[&](auto* r) { memory(r)->set_path("/dev/zero"); }, absl::StatusCode::kFailedPrecondition,
       "it is not a regular file"},
  };
  for (const auto& [damage, code, message] : cases) {
    DamagingServer between(channel, 0, damage);
    const auto client = procgen_client::Client::Connect(between.address());
    ASSERT_THAT(client, IsOk());
    EXPECT_THAT((*client)->Attach(pool, {.take_over = true}), StatusIs(code, HasSubstr(message)));
  }
}

}  // namespace
}  // namespace procgen
