// dm_env_rpc on a real server: the stream's own behaviour, and worlds as pools.
// tests/server/dm_env_rpc and tests/clients/dm_env_rpc test the session.

#include <memory>
#include <string>
#include <thread>

#include "dm_env_rpc/v1/dm_env_rpc.grpc.pb.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/raw_call.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

namespace dm = ::dm_env_rpc::v1;

using testing::HasSubstr;

constexpr char kProcess[] = "/dm_env_rpc.v1.Environment/Process";

dm::EnvironmentRequest CreateRequest() {
  dm::EnvironmentRequest request;
  auto& settings = *request.mutable_create_world()->mutable_settings();
  settings["env_name"].mutable_strings()->add_array("maze");
  return request;
}

dm::EnvironmentRequest JoinRequest(const std::string& world) {
  dm::EnvironmentRequest request;
  request.mutable_join_world()->set_world_name(world);
  return request;
}

dm::EnvironmentRequest EmptyStepRequest() {
  dm::EnvironmentRequest request;
  request.mutable_step();
  return request;
}

// The stream of one agent.
class AgentStream {
 public:
  explicit AgentStream(const std::shared_ptr<grpc::Channel>& channel)
      : stub_(dm::Environment::NewStub(channel)), stream_(stub_->Process(&context_)) {}
  ~AgentStream() {
    if (!finished_) {
      context_.TryCancel();
      Finish().IgnoreError();
    }
  }
  AgentStream(const AgentStream&) = delete;
  AgentStream& operator=(const AgentStream&) = delete;

  void Send(const dm::EnvironmentRequest& request) { stream_->Write(request); }
  dm::EnvironmentResponse Receive() {
    dm::EnvironmentResponse response;
    EXPECT_TRUE(stream_->Read(&response));
    return response;
  }
  dm::EnvironmentResponse Ask(const dm::EnvironmentRequest& request) {
    Send(request);
    return Receive();
  }
  std::string Create() { return Ask(CreateRequest()).create_world().world_name(); }
  void HalfClose() { stream_->WritesDone(); }
  absl::Status Finish() {
    dm::EnvironmentResponse response;
    while (stream_->Read(&response)) {
    }
    finished_ = true;
    const grpc::Status status = stream_->Finish();
    return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
  }
  // Whether the trailing metadata says that the server drains.
  bool SaysDrains() const {
    return context_.GetServerTrailingMetadata().count("procgen-drains") == 1;
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<dm::Environment::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<dm::EnvironmentRequest, dm::EnvironmentResponse>>
      stream_;
  bool finished_ = false;
};

class DmEnvRpcTest : public ServiceTest {};

TEST_F(DmEnvRpcTest, InvalidMessagesGetErrorsAndTheStreamContinues) {
  const RawResult result = CallRaw(
      channel_, kProcess, {"\x0a\xff\xff", CreateRequest().SerializeAsString(), "", "\xff"});
  EXPECT_THAT(result.status, IsOk());
  ASSERT_EQ(result.responses.size(), 4U);
  dm::EnvironmentResponse response;
  ASSERT_TRUE(response.ParseFromString(result.responses[0]));
  EXPECT_EQ(response.error().code(), static_cast<int32_t>(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(response.error().message(),
            "the request's 3 bytes are not a valid dm_env_rpc.v1.EnvironmentRequest");
  ASSERT_TRUE(response.ParseFromString(result.responses[1]));
  EXPECT_TRUE(response.has_create_world());
  ASSERT_TRUE(response.ParseFromString(result.responses[2]));
  EXPECT_THAT(response.error().message(), HasSubstr("is empty, allowed"));
  ASSERT_TRUE(response.ParseFromString(result.responses[3]));
  EXPECT_THAT(response.error().message(), HasSubstr("1 bytes are not a valid"));
}

TEST_F(DmEnvRpcTest, RequestsBeforeHalfCloseAreAnsweredInOrder) {
  AgentStream agent(channel_);
  agent.Send(JoinRequest(agent.Create()));
  for (int i = 0; i < 20; ++i) {
    agent.Send(EmptyStepRequest());
  }
  agent.HalfClose();
  EXPECT_TRUE(agent.Receive().has_join_world());
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(agent.Receive().has_step());
  }
  EXPECT_THAT(agent.Finish(), IsOk());
}

TEST_F(DmEnvRpcTest, AWorldIsAPoolOfItsOwner) {
  AgentStream agent(channel_);
  const std::string world = agent.Create();
  absl::StatusOr<v1::Pool> pool = client_->GetPool(world);
  ASSERT_THAT(pool, IsOk());
  EXPECT_FALSE(pool->attached());
  agent.Ask(JoinRequest(world));
  agent.Ask(EmptyStepRequest());
  agent.Ask(EmptyStepRequest());
  pool = client_->GetPool(world);
  ASSERT_THAT(pool, IsOk());
  EXPECT_TRUE(pool->attached());
  EXPECT_EQ(pool->step_count(), 1);  // The first dm_env_rpc step only starts the episode.
  EXPECT_THAT(client_->Attach(world),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("another stream")));
}

TEST_F(DmEnvRpcTest, APoolIsAWorldOfItsOwner) {
  const std::string pool = CreatePool(MazeSpec(3));
  AgentStream agent(channel_);
  const dm::EnvironmentResponse joined = agent.Ask(JoinRequest(pool));
  ASSERT_TRUE(joined.has_join_world()) << joined.ShortDebugString();
  EXPECT_THAT(joined.join_world().specs().actions().at(1).shape(), testing::ElementsAre(3));
  EXPECT_TRUE(agent.Ask(EmptyStepRequest()).has_step());
}

TEST_F(DmEnvRpcTest, ABrokenStreamLeavesItsWorld) {
  std::string world;
  {
    AgentStream agent(channel_);
    world = agent.Create();
    agent.Ask(JoinRequest(world));
  }
  AgentStream other(channel_);
  dm::EnvironmentResponse joined;
  do {
    joined = other.Ask(JoinRequest(world));  // until the server detects the broken stream
  } while (joined.has_error());
  EXPECT_TRUE(other.Ask(EmptyStepRequest()).has_step());
}

TEST_F(DmEnvRpcTest, BrokenStreamStopsWaitingForAWorld) {
  AgentStream player(channel_);
  const std::string world = player.Create();
  player.Ask(JoinRequest(world));
  player.Ask(EmptyStepRequest());
  {
    AgentStream waiting(channel_);
    dm::EnvironmentRequest reset;
    reset.mutable_reset_world()->set_world_name(world);
    waiting.Send(reset);
  }
  // The response is a step, whether or not the server executed the reset before the stream broke.
  const dm::EnvironmentResponse step = player.Ask(EmptyStepRequest());
  EXPECT_TRUE(step.has_step());
  player.HalfClose();
  EXPECT_THAT(player.Finish(), IsOk());
}

TEST_F(DmEnvRpcTest, JoinedAndUnjoinedStreamsEndWhenTheServerDrains) {
  AgentStream idle(channel_);
  const std::string world = idle.Create();
  AgentStream player(channel_);
  player.Ask(JoinRequest(world));
  player.Ask(EmptyStepRequest());
  server_is_alive_ = false;
  server_->BeginDrain();
  for (AgentStream* stream : {&idle, &player}) {
    EXPECT_THAT(stream->Finish(), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
    EXPECT_TRUE(stream->SaysDrains());
  }
  AgentStream late(channel_);
  EXPECT_THAT(late.Finish(), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
}

TEST_F(DmEnvRpcTest, ErrorsAreCountedByCode) {
  AgentStream agent(channel_);
  EXPECT_TRUE(agent.Ask(EmptyStepRequest()).has_error());
  EXPECT_THAT(
      server_->metrics().Text(),
      HasSubstr(
          R"(procgen_errors_total{code="FAILED_PRECONDITION",method="Environment/Process"} 1)"));
}

TEST_F(DmEnvRpcTest, ManyAgentsPlayAtOnce) {
  std::vector<std::thread> threads;
  threads.reserve(3);
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([this] {
      AgentStream agent(channel_);
      const std::string world = agent.Create();
      agent.Ask(JoinRequest(world));
      for (int step = 0; step < 200; ++step) {
        EXPECT_TRUE(agent.Ask(EmptyStepRequest()).has_step());
      }
      dm::EnvironmentRequest request;
      request.mutable_leave_world();
      agent.Ask(request);
      request.mutable_destroy_world()->set_world_name(world);
      EXPECT_TRUE(agent.Ask(request).has_destroy_world());
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
}

}  // namespace
}  // namespace procgen
