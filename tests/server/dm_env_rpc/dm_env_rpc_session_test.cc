// The state machine of a dm_env_rpc session, without gRPC. tests/clients/dm_env_rpc tests it
// through gRPC.

#include "server/dm_env_rpc/dm_env_rpc_session.h"

#include <memory>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/server/dm_env_rpc/test_session.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

MATCHER_P2(IsError, code, message, "is an error") {
  *result_listener << arg.ShortDebugString().substr(0, 500);
  return arg.has_error() && arg.error().code() == static_cast<int32_t>(code) &&
         testing::Value(arg.error().message(), message);
}

class DmEnvRpcSessionTest : public testing::Test {
 protected:
  static Limits TestLimits() {
    Limits limits;
    limits.response_bytes_max = 64 << 10;
    limits.owner_pool_count_max = 4;
    return limits;
  }

  std::unique_ptr<TestSession> MakeSession(const std::string& owner = "") {
    return std::make_unique<TestSession>(&supervisor_, &worlds_, owner);
  }

  static SettingList Maze() {
    return {{"env_name", TextTensor("maze")},
            {"distribution_mode", TextTensor("easy")},
            {"rand_seed", IntegerTensor(7)}};
  }

  static SettingList MazeBatch(int32_t env_count) {
    SettingList settings = Maze();
    settings["num_envs"] = IntegerTensor(env_count);
    return settings;
  }

  static std::string CreateWorld(TestSession* session, const SettingList& settings = Maze()) {
    const dm::EnvironmentResponse response = session->Create(settings);
    EXPECT_TRUE(response.has_create_world()) << response.ShortDebugString();
    return response.create_world().world_name();
  }

  static std::string JoinNewWorld(TestSession* session, const SettingList& settings = Maze()) {
    std::string world = CreateWorld(session, settings);
    EXPECT_TRUE(session->Join(world).has_join_world());
    return world;
  }

  Metrics metrics_{"test"};
  PoolSupervisor supervisor_{TestLimits(), 2, &metrics_};
  JoinedWorlds worlds_;
};

TEST_F(DmEnvRpcSessionTest, WorldLifecycle) {
  const auto session = MakeSession();
  const std::string world = JoinNewWorld(session.get());
  EXPECT_EQ(session->Step(4).step().state(), dm::RUNNING);
  EXPECT_EQ(session->Step(4).step().state(), dm::RUNNING);
  EXPECT_TRUE(session->Leave().has_leave_world());
  EXPECT_TRUE(session->Destroy(world).has_destroy_world());
  EXPECT_THAT(session->Join(world), IsError(absl::StatusCode::kNotFound, HasSubstr(world)));
}

TEST_F(DmEnvRpcSessionTest, WorldsArePrivateToTheirOwner) {
  const auto alice = MakeSession("alice");
  const auto bob = MakeSession("bob");
  const std::string world = CreateWorld(alice.get());
  EXPECT_THAT(bob->Join(world), IsError(absl::StatusCode::kNotFound, HasSubstr(world)));
  EXPECT_THAT(bob->Destroy(world), IsError(absl::StatusCode::kNotFound, HasSubstr(world)));
  EXPECT_THAT(bob->Call(TestSession::ResetWorldRequest(world)),
              IsError(absl::StatusCode::kNotFound, HasSubstr(world)));
  EXPECT_TRUE(alice->Join(world).has_join_world());
}

// A message with part of a character would be invalid UTF-8.
TEST_F(DmEnvRpcSessionTest, LongNamesAreTruncatedAtCharacterBoundaries) {
  const auto session = MakeSession();
  std::string name = "pools/";
  for (int i = 0; i < 1000; ++i) {
    name += "\xe2\x82\xac";
  }
  SettingList settings = Maze();
  settings["pool_id"] = TextTensor(name);
  for (const dm::EnvironmentResponse& response :
       {session->Join(name), session->Destroy(name),
        session->Call(TestSession::ResetWorldRequest(name)), session->Create(settings)}) {
    EXPECT_THAT(response, IsError(absl::StatusCode::kInvalidArgument, HasSubstr("...', allowed")));
    EXPECT_LT(response.error().message().size(), 200U);
    dm::EnvironmentResponse parsed;
    EXPECT_TRUE(parsed.ParseFromString(response.SerializeAsString()));
  }
}

TEST_F(DmEnvRpcSessionTest, QuotasAndLimitsHold) {
  const auto session = MakeSession();
  for (int i = 0; i < TestLimits().owner_pool_count_max; ++i) {
    CreateWorld(session.get());
  }
  EXPECT_THAT(session->Create(Maze()), IsError(absl::StatusCode::kResourceExhausted,
                                               HasSubstr("owner_pool_count_max is 4")));
}

TEST_F(DmEnvRpcSessionTest, OversizedResponseIsRejectedBeforeTheStep) {
  const auto session = MakeSession();
  JoinNewWorld(session.get(), MazeBatch(6));
  EXPECT_THAT(session->Step(4, {1}), IsError(absl::StatusCode::kResourceExhausted,
                                             HasSubstr("limit response_bytes_max is 65536")));
  EXPECT_EQ(session->Step(4, {2}).step().state(), dm::RUNNING);
}

TEST_F(DmEnvRpcSessionTest, ErrorClearsTheResponse) {
  const auto session = MakeSession();
  JoinNewWorld(session.get());
  const dm::EnvironmentResponse response = session->Step(4, {1, 4711});
  EXPECT_THAT(response, IsError(absl::StatusCode::kInvalidArgument, HasSubstr("4711")));
  EXPECT_FALSE(response.has_step());
}

TEST_F(DmEnvRpcSessionTest, DeletedWorldIsReportedOnceAndAnotherCanBeJoined) {
  const auto session = MakeSession();
  const std::string world = JoinNewWorld(session.get());
  ASSERT_THAT(supervisor_.Delete("", world), IsOk());
  EXPECT_THAT(session->Step(4), IsError(absl::StatusCode::kAborted, HasSubstr("was deleted")));
  EXPECT_THAT(session->Step(4),
              IsError(absl::StatusCode::kFailedPrecondition, HasSubstr("no world is joined")));
  JoinNewWorld(session.get());
  EXPECT_EQ(session->Step(4).step().state(), dm::RUNNING);
}

TEST_F(DmEnvRpcSessionTest, TakeoverGetsThePool) {
  const auto session = MakeSession();
  const std::string world = JoinNewWorld(session.get());
  const auto pool = supervisor_.Find("", world);
  ASSERT_THAT(pool, IsOk());
  absl::Notification attached;
  AttachOptions options;
  options.take_over = true;
  (*pool)->Attach(
      options, [](StreamEnd /*why*/, const absl::Status& /*reason*/) {},
      [&attached](const absl::Status& status) {
        EXPECT_THAT(status, IsOk());
        attached.Notify();
      });
  attached.WaitForNotification();
  EXPECT_THAT(session->Step(4), IsError(absl::StatusCode::kAborted, HasSubstr("took over")));
  EXPECT_THAT(session->Join(world), IsError(absl::StatusCode::kFailedPrecondition,
                                            HasSubstr("another stream is attached")));
  (*pool)->Detach();
  EXPECT_TRUE(session->Join(world).has_join_world());
}

TEST_F(DmEnvRpcSessionTest, ResetWaitsUntilTheOtherAgentIsNotified) {
  const auto player = MakeSession();
  const auto other = MakeSession();
  const std::string world = JoinNewWorld(player.get());
  EXPECT_EQ(player->Step(4).step().state(), dm::RUNNING);
  TestSession::Pending reset;
  reset.request = TestSession::ResetWorldRequest(world);
  (*reset.request.mutable_reset_world()->mutable_settings())["level_seed"] = IntegerTensor(123);
  other->Send(&reset);
  EXPECT_FALSE(reset.answered.HasBeenNotified());
  // An invalid step does not interrupt the agent.
  EXPECT_THAT(player->Step(99), IsError(absl::StatusCode::kInvalidArgument, HasSubstr("99")));
  EXPECT_FALSE(reset.answered.HasBeenNotified());
  EXPECT_EQ(player->Step(4).step().state(), dm::INTERRUPTED);
  reset.answered.WaitForNotification();
  EXPECT_TRUE(reset.response.has_reset_world());
  const dm::EnvironmentResponse begun = player->Step(4, {3});
  EXPECT_EQ(begun.step().state(), dm::RUNNING);
  EXPECT_EQ(begun.step().observations().at(3).int32s().array(0), 123);
}

TEST_F(DmEnvRpcSessionTest, ResetOfALeftWorldIsExecuted) {
  const auto player = MakeSession();
  const auto other = MakeSession();
  const std::string world = JoinNewWorld(player.get());
  player->Step(4);
  TestSession::Pending reset;
  reset.request = TestSession::ResetWorldRequest(world);
  (*reset.request.mutable_reset_world()->mutable_settings())["level_seed"] = IntegerTensor(123);
  other->Send(&reset);
  player->Leave();
  reset.answered.WaitForNotification();
  EXPECT_TRUE(reset.response.has_reset_world());
  player->Join(world);
  EXPECT_EQ(player->Step(4, {3}).step().observations().at(3).int32s().array(0), 123);
}

TEST_F(DmEnvRpcSessionTest, CancelledResetReturnsAndTheOtherAgentContinues) {
  const auto player = MakeSession();
  const auto other = MakeSession();
  const std::string world = JoinNewWorld(player.get());
  player->Step(4);
  TestSession::Pending reset;
  reset.request = TestSession::ResetWorldRequest(world);
  other->Send(&reset);
  other->session().CancelWait();
  reset.answered.WaitForNotification();
  EXPECT_THAT(reset.response, IsError(absl::StatusCode::kCancelled, HasSubstr("stream ended")));
  EXPECT_EQ(player->Step(4).step().state(), dm::RUNNING);
  // Later requests do not wait either.
  EXPECT_THAT(other->Call(TestSession::ResetWorldRequest(world)),
              IsError(absl::StatusCode::kCancelled, HasSubstr("stream ended")));
}

TEST_F(DmEnvRpcSessionTest, JoiningAnOccupiedWorldErrorNamesTheRemedy) {
  const auto session = MakeSession();
  const auto other = MakeSession();
  const std::string world = JoinNewWorld(session.get());
  EXPECT_THAT(other->Join(world),
              IsError(absl::StatusCode::kFailedPrecondition,
                      AllOf(HasSubstr("another stream is attached"),
                            HasSubstr("send LeaveWorld there"), Not(HasSubstr("take_over")))));
  session->Leave();
  EXPECT_TRUE(other->Join(world).has_join_world());
}

TEST_F(DmEnvRpcSessionTest, NextLevelSeedTakesAnyIntegerType) {
  const auto session = MakeSession();
  JoinNewWorld(session.get());
  session->Step(4);
  EXPECT_TRUE(session->Write("next_level_seed", IntegerTensor(123)).has_extension());
  EXPECT_THAT(
      session->Write("next_level_seed", IntegerTensor(int64_t{INT32_MAX} + 1)),
      IsError(absl::StatusCode::kInvalidArgument, HasSubstr("next_level_seed is 2147483648")));
  session->Reset();
  EXPECT_EQ(session->Step(4, {3}).step().observations().at(3).int32s().array(0), 123);
}

TEST_F(DmEnvRpcSessionTest, WorldAttachedByStepPoolIsNotReset) {
  const auto session = MakeSession();
  const std::string world = CreateWorld(session.get());
  const auto pool = supervisor_.Find("", world);
  ASSERT_THAT(pool, IsOk());
  (*pool)->Attach(
      AttachOptions(), [](StreamEnd /*why*/, const absl::Status& /*reason*/) {},
      [](const absl::Status& status) { EXPECT_THAT(status, IsOk()); });
  EXPECT_THAT(session->Call(TestSession::ResetWorldRequest(world)),
              IsError(absl::StatusCode::kFailedPrecondition, HasSubstr("another stream")));
  EXPECT_EQ((*pool)->next_sequence_number(), 1);
  (*pool)->Detach();
}

TEST_F(DmEnvRpcSessionTest, RejoiningMidEpisodeStartsANewEpisode) {
  const auto session = MakeSession();
  const std::string world = JoinNewWorld(session.get());
  const auto level = [&] {
    return session->Step(4, {3}).step().observations().at(3).int32s().array(0);
  };
  const int32_t first = level();
  session->Leave();
  session->Join(world);
  EXPECT_EQ(level(), first);  // No step since the episode's first observation.
  session->Step(7);
  session->Leave();
  session->Join(world);
  EXPECT_NE(level(), first);
}

TEST_F(DmEnvRpcSessionTest, StatesOfTwoEnvironmentsAreIndependent) {
  const auto session = MakeSession();
  const std::string world = JoinNewWorld(session.get(), MazeBatch(2));
  dm::EnvironmentRequest request;
  (*request.mutable_step()->mutable_actions())[kActionUid].mutable_int32s()->add_array(4);
  (*request.mutable_step()->mutable_actions())[kActionUid].mutable_int32s()->add_array(-1);
  (*request.mutable_step()->mutable_actions())[kActionUid].add_shape(2);
  for (const uint64_t uid : {9, 10, 11}) {
    request.mutable_step()->add_requested_observations(uid);
  }
  EXPECT_EQ(session->Call(request).step().state(), dm::RUNNING);
  const dm::EnvironmentResponse response = session->Call(request);
  const auto flags = [&](uint64_t uid) { return response.step().observations().at(uid).bools(); };
  EXPECT_THAT(flags(9).array(), testing::ElementsAre(false, true));
  EXPECT_THAT(flags(10).array(), testing::ElementsAre(false, true));
  EXPECT_THAT(flags(11).array(), testing::ElementsAre(false, false));
}

TEST_F(DmEnvRpcSessionTest, DrainRejectsCreateAndJoin) {
  const auto session = MakeSession();
  const std::string world = CreateWorld(session.get());
  supervisor_.Drain();
  EXPECT_THAT(session->Create(Maze()),
              IsError(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  EXPECT_THAT(session->Join(world), IsError(absl::StatusCode::kUnavailable, HasSubstr("drains")));
}

TEST_F(DmEnvRpcSessionTest, InvalidExtensionsAreNamed) {
  const auto session = MakeSession();
  dm::EnvironmentRequest request;
  request.mutable_extension()->set_type_url(
      "type.googleapis.com/dm_env_rpc.v1.extensions.properties.PropertyRequest");
  request.mutable_extension()->set_value("\xff\xff");
  EXPECT_THAT(session->Call(request), IsError(absl::StatusCode::kInvalidArgument,
                                              HasSubstr("2 bytes are not a valid dm_env_rpc")));
  request.mutable_extension()->set_value("");
  EXPECT_THAT(session->Call(request), IsError(absl::StatusCode::kInvalidArgument,
                                              HasSubstr("is empty, allowed: read_property")));
  request.mutable_extension()->set_type_url("gibberish");
  EXPECT_THAT(session->Call(request),
              IsError(absl::StatusCode::kUnimplemented, HasSubstr("type gibberish, offered:")));
}

}  // namespace
}  // namespace procgen
