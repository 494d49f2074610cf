// A fleet with a node that returns damaged responses, through a proxy. The learner's responses
// equal those of one server and contain none of the fleet server's memory.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/fleet/fleet_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

struct Attack {
  std::string name;
  AnswerDamage damage;
  int attacked_request = 60;  // the first damaged one; 0: also CreatePool
};

Attack OnBatch(const std::string& name, std::function<void(v1::Batch*)> damage) {
  Attack attack = {name, {}};
  attack.damage.step = [damage = std::move(damage)](v1::StepPoolResponse* response) {
    damage(response->mutable_batch());
  };
  return attack;
}

void EndAll(v1::Batch* batch) {
  for (bool& terminated : *batch->mutable_terminated()) {
    terminated = true;
  }
}

std::vector<Attack> AttacksOnBatches() {
  return {
      OnBatch("ObservationsOfTenBytes",
              [](v1::Batch* batch) { batch->set_observations(std::string(10, '\1')); }),
      OnBatch("NoObservations", [](v1::Batch* batch) { batch->clear_observations(); }),
      OnBatch("OneReward", [](v1::Batch* batch) { batch->mutable_rewards()->Truncate(1); }),
      OnBatch("NoEnds",
              [](v1::Batch* batch) {
                batch->clear_terminated();
                batch->clear_truncated();
              }),
      OnBatch("MoreSeedsThanRows", [](v1::Batch* batch) { batch->add_level_seeds(1); }),
      OnBatch("FirstEnvFarOff", [](v1::Batch* batch) { batch->set_first_env(1 << 30); }),
      OnBatch("FirstEnvNegative", [](v1::Batch* batch) { batch->set_first_env(-(1 << 30)); }),
      OnBatch("NoRows",
              [](v1::Batch* batch) {
                batch->Clear();
                batch->set_last(true);
              }),
      OnBatch("RowsNegative", [](v1::Batch* batch) { batch->set_env_count(-1); }),
      OnBatch("EndsWithoutFingerprints",
              [](v1::Batch* batch) {
                EndAll(batch);
                batch->clear_fingerprints();
                batch->add_fingerprints(7);
              }),
      OnBatch("EndsWithoutFinalObservations", EndAll),
      OnBatch("UnofferedSharedMemory",
              [](v1::Batch* batch) {
                batch->Clear();
                batch->set_shared_batch(0);
                batch->set_last(true);
              }),
  };
}

std::vector<Attack> AttacksOnMessages() {
  std::vector<Attack> attacks;
  attacks.push_back({"AckInPlaceOfABatch", {}});
  attacks.back().damage.step = [](v1::StepPoolResponse* response) {
    response->clear_batch();
    response->mutable_ack();
  };
  attacks.push_back({"NoStates", {}});
  attacks.back().damage.states = [](v1::SaveStatesResponse* response) { response->clear_states(); };
  attacks.push_back({"StatesOfAnotherEnvironment", {}});
  attacks.back().damage.states = [](v1::SaveStatesResponse* response) {
    for (v1::State& state : *response->mutable_states()) {
      state.set_environment(1000);
    }
  };
  attacks.push_back({"LimitsThatMakeNoSense", {}, 0});
  attacks.back().damage.catalog = [](v1::Catalog* catalog) {
    catalog->mutable_limits()->set_requests_in_flight_max(-1);
    catalog->mutable_limits()->set_response_bytes_max(-1);
    catalog->mutable_limits()->mutable_lease_duration_max()->set_seconds(-1);
  };
  attacks.push_back({"AnotherPoolThanWasAskedFor", {}, 0});
  attacks.back().damage.pool = [](v1::Pool* pool) { pool->set_name("pools/another"); };
  attacks.push_back({"APoolOfOtherEnvironments", {}, 0});
  attacks.back().damage.attached = [](v1::StepPoolResponse* response) {
    response->mutable_attached()->mutable_pool()->mutable_spec()->set_env_count(1 << 30);
  };
  attacks.push_back({"NoRequestsInFlight", {}, 0});
  attacks.back().damage.attached = [](v1::StepPoolResponse* response) {
    response->mutable_attached()->set_requests_in_flight_max(0);
  };
  return attacks;
}

class HostileNodeTest : public FleetTest {
 protected:
  // No rebalancing: only the shards of the hostile node move.
  void SetUp() override {
    FleetTest::SetUp();
    poll_interval_ = absl::InfiniteDuration();
  }
};

class WrongAnswerTest : public HostileNodeTest, public testing::WithParamInterface<Attack> {};

TEST_P(WrongAnswerTest, DoesNotReachTheLearner) {
  StartNode("a");
  HostileNode* const hostile = StartHostileNode("b", GetParam().damage);
  hostile->Attack(GetParam().attacked_request == 0);
  StartFleet();
  LearnerScript script = Script(160);
  script.spec.set_autoreset_mode(v1::AUTORESET_MODE_SAME_STEP);
  ExpectSameTrace(script, [&](int index) {
    if (index == GetParam().attacked_request) {
      hostile->Attack(true);
    }
    if (index == 140) {
      nodes_.erase("b");  // its shards continue on other nodes, from their checkpoints
    }
  });
  EXPECT_GE(hostile->damage_count(), 1);
}

std::string NameOf(const testing::TestParamInfo<Attack>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(Batches, WrongAnswerTest, testing::ValuesIn(AttacksOnBatches()), NameOf);
INSTANTIATE_TEST_SUITE_P(Messages, WrongAnswerTest, testing::ValuesIn(AttacksOnMessages()), NameOf);

TEST_F(HostileNodeTest, MissingFramesAreDrawnByOtherNodes) {
  AnswerDamage damage;
  damage.frames = [](v1::RenderEnvironmentsResponse* response) { response->clear_frames(); };
  HostileNode* const hostile = StartHostileNode("b", damage);
  StartFleet();
  const auto client = Connect(*server_);
  const auto pool = client->CreatePool(Script().spec);
  ASSERT_THAT(pool, IsOk());
  const auto expected = client->RenderEnvironments(pool->name(), {0, 1, 23}, 64);
  ASSERT_THAT(expected, IsOk());
  StartNode("a");
  hostile->Attack(true);
  const auto actual = client->RenderEnvironments(pool->name(), {0, 1, 23}, 64);
  ASSERT_THAT(actual, IsOk());
  EXPECT_EQ(actual->SerializeAsString(), expected->SerializeAsString());
  EXPECT_EQ(hostile->damage_count(), 1);
}

TEST_F(HostileNodeTest, SoleHostileNodeIsRetriedWithBackoff) {
  failover_timeout_ = absl::Seconds(4);
  AnswerDamage damage;
  damage.step = [](v1::StepPoolResponse* response) {
    response->mutable_batch()->set_observations(std::string(10, '\1'));
  };
  HostileNode* const hostile = StartHostileNode("b", damage);
  StartFleet();
  const auto client = Connect(*server_);
  const auto stream = client->Attach(client->CreatePool(Script().spec)->name()).value();
  hostile->Attack(true);
  procgen_client::Batch batch;
  EXPECT_THAT(
      stream->Observe(&batch),
      StatusIs(absl::StatusCode::kDeadlineExceeded,
               testing::HasSubstr("have had no node for 4s, limit fleet_failover_timeout")));
  EXPECT_GE(hostile->damage_count(), 2);
  EXPECT_LE(hostile->damage_count(), 3) << "it is excluded for 1 s, then for 2 s";
}

}  // namespace
}  // namespace procgen
