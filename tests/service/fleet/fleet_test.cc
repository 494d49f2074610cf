// A fleet server whose nodes are processes; the test reports the nodes. The learner's responses
// equal those of one server, whatever happens to the nodes. The fleet detects faults by its
// connections only; fleet_cluster_test.cc uses a real cluster.

#include "server/fleet/fleet.h"

#include <csignal>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/fleet/fleet_fixture.h"
#include "tests/service/security/certificates.h"
#include "tests/service/stream/batch_copy.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

v1::PoolSpec SmallSpec() {
  v1::PoolSpec spec;
  spec.add_games("coinrun");
  spec.set_env_count(8);
  spec.mutable_options()->set_rand_seed(3);
  return spec;
}

class FleetFormatTest : public FleetTest,
                        public testing::WithParamInterface<std::pair<v1::AutoresetMode, int>> {};

TEST_P(FleetFormatTest, ThreeNodesEqualOneServer) {
  StartNode("a");
  StartNode("b");
  StartNode("c");
  StartFleet();
  LearnerScript script = Script();
  script.spec.set_autoreset_mode(GetParam().first);
  script.spec.mutable_observation_format()->set_frame_stack(GetParam().second);
  script.with_states = GetParam().first != v1::AUTORESET_MODE_DISABLED;
  ExpectSameTrace(script, [](int) {});
}

INSTANTIATE_TEST_SUITE_P(AutoresetModesAndStacks, FleetFormatTest,
                         testing::Values(std::pair(v1::AUTORESET_MODE_SAME_STEP, 1),
                                         std::pair(v1::AUTORESET_MODE_NEXT_STEP, 3),
                                         std::pair(v1::AUTORESET_MODE_DISABLED, 1)));

TEST_F(FleetTest, KilledNodesDoNotChangeBatches) {
  // No rebalancing: only the shards of killed nodes move.
  poll_interval_ = absl::InfiniteDuration();
  StartNode("a");
  StartNode("b");
  StartNode("c");
  StartFleet();
  ExpectSameTrace(Script(), [&](int index) {
    if (index == 130) {
      nodes_.erase("b");
    }
    if (index == 250) {
      nodes_.erase("a");
    }
  });
  EXPECT_THAT(MetricsText(), testing::HasSubstr("procgen_fleet_shard_migrations_total 3"));
}

TEST_F(FleetTest, FrameStacksSurviveAMigration) {
  StartNode("a");
  StartNode("b");
  StartFleet(10);
  LearnerScript script = Script();
  script.spec.mutable_observation_format()->set_frame_stack(4);
  ExpectSameTrace(script, [&](int index) {
    if (index == 333) {
      nodes_.erase("b");
    }
  });
}

TEST_F(FleetTest, StoppedNodeLosesItsShardsAndItsLateResponses) {
  StartNode("a");
  StartNode("b");
  StartFleet();
  ExpectSameTrace(Script(), [&](int index) {
    if (index == 100) {
      nodes_["b"]->Signal(SIGSTOP);
    }
    if (index == 200) {
      nodes_["b"]->Signal(SIGCONT);
    }
    if (index == 300) {
      nodes_.erase("a");
    }
  });
}

TEST_F(FleetTest, DrainingNodesEndBeforeTheirTimeout) {
  StartNode("a");
  StartNode("b");
  StartFleet();
  std::unique_ptr<ServerProcess> drained;
  ExpectSameTrace(Script(), [&](int index) {
    if (index == 150) {
      nodes_["b"]->Signal(SIGTERM);
      NodeStatus status = list_.Nodes().back();
      status.draining = true;
      list_.Set(status);
      drained = std::move(nodes_["b"]);
    }
  });
  const absl::Time begin = absl::Now();
  EXPECT_EQ(drained->Wait(), 0);
  EXPECT_LT(absl::Now() - begin, absl::Seconds(15)) << "its shards were not taken away";
}

TEST_F(FleetTest, BatchOutlivesItsNode) {
  for (const char* node_id : {"a", "b", "c"}) {
    StartNode(node_id);
  }
  StartFleet();
  constexpr int kStepCount = 20;
  const auto last_answer = [](const Server& server, const std::function<void()>& before_last) {
    const auto client = Connect(server);
    const auto stream = client->Attach(client->CreatePool(Script().spec)->name()).value();
    procgen_client::Batch batch;
    for (int step = 1; step <= kStepCount; ++step) {
      if (step == kStepCount) {
        before_last();
      }
      const std::vector<int32_t> actions(static_cast<size_t>(stream->env_count()), step % 15);
      EXPECT_THAT(stream->Step(actions, &batch), IsOk());
    }
    return BatchCopy(batch);
  };
  const BatchCopy expected = last_answer(*single_, [] {});
  std::thread operator_thread;
  const BatchCopy actual = last_answer(*server_, [&] {
    NodeStatus full = list_.Nodes()[1];
    full.environment_capacity = 8;
    list_.Set(full);
    nodes_["b"]->Signal(SIGSTOP);
    operator_thread = std::thread([&] {
      // Drains node "a" when its shard has stepped and waits for "b", which is stopped.
      NodeStatus drained = list_.Nodes()[0];
      const auto client = Connect(drained.address);
      while (client->GetLoad()->step_count() < int64_t{8} * kStepCount) {
      }
      drained.draining = true;
      list_.Set(drained);
      while (client->GetLoad()->pool_count() > 0) {
      }
      nodes_["b"]->Signal(SIGCONT);
    });
  });
  operator_thread.join();
  EXPECT_TRUE(actual == expected);
}

class FleetJoinTest : public FleetTest, public testing::WithParamInterface<int> {};

TEST_P(FleetJoinTest, NodesThatJoinTakeTheirShare) {
  StartNode("a");
  StartFleet();
  LearnerScript script = Script();
  script.spec.mutable_observation_format()->set_frame_stack(GetParam());
  v1::Load load;
  ExpectSameTrace(script, [&](int index) {
    if (index == 100) {
      StartNode("b");
    }
    if (index > 100 && index < 350) {
      absl::SleepFor(absl::Milliseconds(15));  // time to rebalance
    }
    if (index == 350) {
      load = Connect(list_.Nodes().back().address)->GetLoad().value();
    }
  });
  EXPECT_EQ(load.env_count(), 12);
}

INSTANTIATE_TEST_SUITE_P(Stacks, FleetJoinTest, testing::Values(1, 3));

TEST_F(FleetTest, ConnectionsFollowNodesToNewAddresses) {
  StartNode("a");
  FleetOptions options;
  options.nodes = [this] { return list_.Nodes(); };
  FleetNodes nodes(options);
  const auto first = nodes.Connect("a");
  ASSERT_THAT(first, IsOk());
  EXPECT_EQ(nodes.Connect("a")->get(), first->get());
  StartNode("a");  // on another port
  EXPECT_EQ((*nodes.Connect("a"))->address, list_.Nodes().front().address);
  EXPECT_EQ(nodes.known_count(), 1);
  list_.Remove("a");
  nodes.OnNodesChanged();
  EXPECT_EQ(nodes.known_count(), 0);
}

TEST_F(FleetTest, ChunkedStepIsCompleteDuringRebalance) {
  constexpr int32_t kEnvCount = 24;
  const auto play = [](const Server& server, const std::function<bool(size_t)>& should_continue) {
    const auto client = Connect(server);
    const auto stream = client->Attach(client->CreatePool(Script().spec)->name()).value();
    procgen_client::Batch batch;
    std::vector<BatchCopy> answers;
    while (should_continue(answers.size())) {
      v1::StepPoolRequest request;
      request.mutable_step()->mutable_slice()->set_env_count(kEnvCount);
      request.mutable_step()->mutable_actions()->Resize(kEnvCount, 7);
      request.mutable_step()->set_repeat_count(1);
      request.mutable_step()->set_observation(v1::OBSERVATION_FRAME);
      request.mutable_step()->set_chunk_count(4);
      EXPECT_THAT(stream->Call(std::move(request), &batch), IsOk());
      answers.emplace_back(batch);
    }
    return answers;
  };
  StartNode("a");
  StartFleet();
  StartNode("b");
  const NodeStatus joining = list_.Nodes().back();
  list_.Remove("b");  // until the pool exists
  const auto node = Connect(joining.address);
  const auto actual = play(*server_, [&](size_t count) {
    if (count == 10) {
      list_.Set(joining);
    }
    return node->GetLoad()->env_count() == 0;
  });
  const auto expected = play(*single_, [&](size_t count) { return count < actual.size(); });
  EXPECT_TRUE(actual == expected);
}

TEST_F(FleetTest, LearnerWaitsUntilANodeJoins) {
  StartNode("a");
  StartFleet();
  std::thread helper;
  ExpectSameTrace(Script(), [&](int index) {
    if (index == 100) {
      nodes_.erase("a");
      list_.Remove("a");
      helper = std::thread([&] {
        absl::SleepFor(absl::Seconds(1));
        StartNode("b");
      });
    }
  });
  helper.join();
}

TEST_F(FleetTest, StreamEndsAfterFailoverTimeoutAndAnotherContinues) {
  const std::vector<int32_t> actions(8, 7);
  procgen_client::Batch batch;
  const auto single = Connect(*single_);
  const auto single_pool = single->CreatePool(SmallSpec());
  ASSERT_THAT(single_pool, IsOk());
  const auto single_stream = single->Attach(single_pool->name());
  ASSERT_THAT(single_stream, IsOk());
  ASSERT_THAT((*single_stream)->Step(actions, &batch), IsOk());
  ASSERT_THAT((*single_stream)->Step(actions, &batch), IsOk());
  const BatchCopy expected(batch);

  failover_timeout_ = absl::Seconds(1);
  StartNode("a");
  StartFleet();
  const auto client = Connect(*server_);
  const auto pool = client->CreatePool(SmallSpec());
  ASSERT_THAT(pool, IsOk());
  {
    const auto stream = client->Attach(pool->name());
    ASSERT_THAT(stream, IsOk());
    ASSERT_THAT((*stream)->Step(actions, &batch), IsOk());
    nodes_.erase("a");
    list_.Remove("a");
    EXPECT_THAT(
        (*stream)->Step(actions, &batch),
        StatusIs(absl::StatusCode::kDeadlineExceeded,
                 testing::HasSubstr(pool->name() +
                                    " have had no node for 1s, limit fleet_failover_timeout")));
  }
  EXPECT_THAT(MetricsText(), testing::HasSubstr("procgen_fleet_shards_waiting 1\n"));

  StartNode("b");
  const auto stream = client->Attach(pool->name());
  ASSERT_THAT(stream, IsOk());
  ASSERT_THAT((*stream)->Step(actions, &batch), IsOk());
  EXPECT_TRUE(BatchCopy(batch) == expected) << "the failed step has changed something";
  EXPECT_THAT(MetricsText(), testing::HasSubstr("procgen_fleet_shards_waiting 0\n"));
}

TEST_F(FleetTest, CreatePoolWithoutNodesIsRejected) {
  StartFleet();
  EXPECT_THAT(Connect(*server_)->CreatePool(SmallSpec()),
              StatusIs(absl::StatusCode::kUnavailable, testing::HasSubstr("no node")));
}

TEST_F(FleetTest, StreamLevelSamplersCountAsOwnerBuffers) {
  Limits limits;
  limits.owner_buffer_bytes_max = 16 << 20;
  StartNode("a");
  StartFleet(/*snapshot_requests=*/50, limits);
  const auto client = Connect(*server_);
  v1::StepPoolRequest request;
  for (int32_t i = 0; i < 200'000; ++i) {  // 3 MB
    request.mutable_level_sampler()->add_level_seeds(i);
    request.mutable_level_sampler()->add_weights(1);
  }
  std::vector<std::unique_ptr<procgen_client::StepStream>> streams;
  absl::Status status;
  while (status.ok() && streams.size() < 10) {
    v1::PoolSpec spec;
    spec.add_games("maze");
    spec.set_env_count(1);
    const auto pool = client->CreatePool(spec);
    ASSERT_THAT(pool, IsOk());
    auto stream = client->Attach(pool->name());
    ASSERT_THAT(stream, IsOk());
    procgen_client::Batch batch;
    ASSERT_THAT((*stream)->Step({4}, &batch), IsOk());
    status = (*stream)->Call(request, &batch);
    streams.push_back(*std::move(stream));
  }
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted,
                               testing::HasSubstr("limit owner_buffer_bytes_max is 16777216")));
  EXPECT_GT(streams.size(), 2);
}

TEST_F(FleetTest, FleetSendsItsTokenOverTls) {
  const Certificates certificates;
  certificates.MakeAuthority("authority");
  certificates.MakeServer("authority", "node");
  certificates.Write("tokens", "fleet the-token-of-the-fleet\n");
  certificates.Write("token", "some-other-token-012345\n");
  credentials_.ca = certificates.Path("authority.pem");
  credentials_.token = certificates.Path("token");
  StartNode("a", {"--tls_certificate=" + certificates.Path("node.pem"),
                  "--tls_key=" + certificates.Path("node.key"),
                  "--tokens=" + certificates.Path("tokens")});
  StartFleet();
  const auto client = Connect(*server_);
  EXPECT_THAT(client->CreatePool(SmallSpec()),
              StatusIs(absl::StatusCode::kPermissionDenied,
                       testing::AllOf(testing::HasSubstr("node a at 127.0.0.1:"),
                                      testing::HasSubstr("rejects the fleet server"),
                                      testing::HasSubstr("--fleet_token"))));
  certificates.Replace("token", "the-token-of-the-fleet\n");
  ExpectSameTrace(Script(40), [](int) {});
}

// A pool with frame stacks and a small request log, and a stream.
class FleetLogTest : public FleetTest {
 protected:
  static constexpr int32_t kEnvCount = 4;

  void SetUp() override {
    log_bytes_max_ = int64_t{32} << 10;
    StartNode("a");
    StartFleet(/*snapshot_requests=*/8);
    client_ = Connect(*server_);
    v1::PoolSpec spec = SmallSpec();
    spec.set_env_count(kEnvCount);
    spec.mutable_observation_format()->set_frame_stack(4);
    name_ = client_->CreatePool(spec).value().name();
    Attach();
  }
  void Attach() { stream_ = *client_->Attach(name_); }

  absl::Status Step(int32_t first) {
    v1::StepPoolRequest request;
    request.mutable_step()->mutable_slice()->set_first_env(first);
    request.mutable_step()->mutable_slice()->set_env_count(kEnvCount - first);
    for (int32_t i = first; i < kEnvCount; ++i) {
      request.mutable_step()->add_actions(4);
    }
    return stream_->Call(std::move(request), &batch_);
  }
  absl::Status Observe() {
    v1::StepPoolRequest request;
    request.mutable_observe();
    return stream_->Call(std::move(request), &batch_);
  }

  std::unique_ptr<procgen_client::Client> client_;
  std::string name_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  procgen_client::Batch batch_;
};

TEST_F(FleetLogTest, LogIsTruncatedDespiteIdleEnvironments) {
  for (int i = 0; i < 800; ++i) {
    ASSERT_THAT(i < 400 ? Observe() : Step(/*first=*/1), IsOk()) << i;
  }
}

TEST_F(FleetLogTest, FullLogAcceptsOnlyStepsOfAllEnvironments) {
  ASSERT_THAT(Step(/*first=*/0), IsOk());
  absl::Status status;
  for (int i = 0; i < 2000 && status.ok(); ++i) {
    status = Step(/*first=*/1);
  }
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted,
                               testing::HasSubstr("bytes, limit log_bytes_max: 32768")));
  Attach();
  for (int i = 0; i < 20; ++i) {
    ASSERT_THAT(Step(/*first=*/0), IsOk()) << i;
  }
  EXPECT_THAT(Step(/*first=*/1), IsOk());
}

TEST_F(FleetTest, FleetDoesNotCallTlsNodesInPlainText) {
  const Certificates certificates;
  certificates.MakeAuthority("authority");
  certificates.MakeServer("authority", "node");
  failover_timeout_ = absl::Seconds(1);
  StartNode("a", {"--tls_certificate=" + certificates.Path("node.pem"),
                  "--tls_key=" + certificates.Path("node.key")});
  StartFleet();
  EXPECT_THAT(Connect(*server_)->CreatePool(SmallSpec()),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       testing::HasSubstr("over plain text without --fleet_ca")));
}

}  // namespace
}  // namespace procgen
