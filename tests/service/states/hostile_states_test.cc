// Invalid snapshots and invalid state requests: each is rejected with a reason and changes nothing.
// The server and other pools continue.

#include <string>
#include <vector>

#include "envcore/random/random_stream.h"
#include "envcore/state/snapshot_frame.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/batch_copy.h"

namespace procgen {
namespace {

using testing::AnyOf;
using testing::HasSubstr;

v1::State StateOf(int32_t environment, const std::string& snapshot) {
  v1::State state;
  state.set_environment(environment);
  state.set_snapshot(snapshot);
  return state;
}

// A pool of two mazes within an episode. Expects after each test that it has not changed.
class HostileStatesTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    name_ = CreatePool(MazeSpec(2));
    absl::StatusOr<std::unique_ptr<procgen_client::StepStream>> stream = client_->Attach(name_);
    ASSERT_THAT(stream, IsOk());
    stream_ = *std::move(stream);
    ASSERT_THAT(stream_->Step({7, 7}, &batch_), IsOk());
    good_ = client_->SaveStates(name_, {0})->front().snapshot();
    ASSERT_THAT(stream_->Observe(&batch_), IsOk());
  }

  void TearDown() override {
    const BatchCopy before(batch_);
    EXPECT_THAT(stream_->Observe(&batch_), IsOk());
    EXPECT_EQ(BatchCopy(batch_), before);
    EXPECT_THAT(stream_->Step({7, 7}, &batch_), IsOk());
    stream_.reset();
    ServiceTest::TearDown();
  }

  // Restores environment 0 from a valid snapshot, and environment 1 from `snapshot`.
  absl::Status Restore(const std::string& snapshot) {
    return client_->RestoreStates(name_, {StateOf(0, good_), StateOf(1, snapshot)});
  }

  std::string name_;
  std::string good_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  procgen_client::Batch batch_;
};

TEST_F(HostileStatesTest, BytesThatAreNoSnapshotAreDataLoss) {
  EXPECT_THAT(Restore(""),
              StatusIs(absl::StatusCode::kDataLoss,
                       "environment 1: the snapshot has 0 bytes, must have at least 16"));
  EXPECT_THAT(Restore(std::string(1000, 'x')),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("do not begin with \"PGST\"")));
  EXPECT_THAT(Restore(good_ + "more"),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("its header says")));
  RandomStream random(3);
  for (int i = 0; i < 200; ++i) {
    std::string cut =
        good_.substr(0, static_cast<size_t>(random.Int(static_cast<int32_t>(good_.size()))));
    EXPECT_THAT(Restore(cut), StatusIs(absl::StatusCode::kDataLoss, HasSubstr("environment 1")));
    std::string flipped = good_;
    flipped[static_cast<size_t>(random.Int(static_cast<int32_t>(good_.size())))] ^= 0x10;
    EXPECT_THAT(Restore(flipped), StatusIs(absl::StatusCode::kDataLoss, testing::_));
  }
}

TEST_F(HostileStatesTest, AnotherVersionIsDataLoss) {
  std::string newer = good_;
  newer[4] = 9;
  EXPECT_THAT(Restore(newer), StatusIs(absl::StatusCode::kDataLoss,
                                       HasSubstr("of version 9, this engine supports version 1")));
}

TEST_F(HostileStatesTest, MissingFieldIsNamed) {
  std::string body = good_.substr(kSnapshotHeaderBytes);
  body.replace(body.find("level_seed"), 10, "level_heed");
  EXPECT_THAT(Restore(FrameSnapshot(body)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("environment 1: level_seed")));
}

TEST_F(HostileStatesTest, AnotherGameIsAFailedPrecondition) {
  v1::PoolSpec spec = MazeSpec(1);
  *spec.mutable_games(0) = "miner";
  const std::string miner = CreatePool(spec);
  const std::string other = client_->SaveStates(miner)->front().snapshot();
  EXPECT_THAT(Restore(other), StatusIs(absl::StatusCode::kFailedPrecondition,
                                       "environment 1: game is miner, the environment plays maze"));
  EXPECT_THAT(client_->CloneStates(name_, {Pair(0, 1)}, {miner, ""}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "environment 1: game is miner, the environment plays maze"));
}

TEST_F(HostileStatesTest, SnapshotLargerThanARequestIsRejected) {
  EXPECT_THAT(Restore(std::string(70000, 'x')),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("65536")));
}

TEST_F(HostileStatesTest, SnapshotLargerThanTheMaximumIsDataLoss) {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const auto client = procgen_client::Client::Connect((*server)->address());
  ASSERT_THAT(client, IsOk());
  const auto pool = (*client)->CreatePool(MazeSpec(1));
  ASSERT_THAT(pool, IsOk());
  EXPECT_THAT((*client)->RestoreStates(pool->name(),
                                       {StateOf(0, FrameSnapshot(std::string(2 << 20, 'x')))}),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("must have at most 1048576")));
}

TEST_F(HostileStatesTest, EnvironmentsOutOfRangeOrRepeatedAreRejected) {
  const auto out_of_range = [&](const std::string& what) {
    return StatusIs(absl::StatusCode::kInvalidArgument,
                    what + ", pool " + name_ + " has environments 0 to 1");
  };
  const auto twice = [](const std::string& what) {
    return StatusIs(absl::StatusCode::kInvalidArgument,
                    what + " again, allowed: each at most once");
  };
  EXPECT_THAT(client_->SaveStates(name_, {0, 2}), out_of_range("environments[1] is 2"));
  EXPECT_THAT(client_->SaveStates(name_, {1, 0, 1}), twice("environments[2] is 1"));
  EXPECT_THAT(client_->RestoreStates(name_, {StateOf(-1, good_)}),
              out_of_range("states[0].environment is -1"));
  EXPECT_THAT(client_->RestoreStates(name_, {StateOf(1, good_), StateOf(1, good_)}),
              twice("states[1].environment is 1"));
  EXPECT_THAT(client_->CloneStates(name_, {Pair(0, 1), Pair(5, 0)}),
              out_of_range("pairs[1].source_environment is 5"));
  EXPECT_THAT(client_->CloneStates(name_, {Pair(0, 7)}),
              out_of_range("pairs[0].target_environment is 7"));
  EXPECT_THAT(client_->CloneStates(name_, {Pair(0, 1), Pair(1, 1)}),
              twice("pairs[1].target_environment is 1"));
}

TEST_F(HostileStatesTest, EmptyRestoreOrCloneIsRejected) {
  EXPECT_THAT(
      client_->RestoreStates(name_, {}),
      StatusIs(absl::StatusCode::kInvalidArgument, "states is empty, allowed: at least one"));
  EXPECT_THAT(client_->CloneStates(name_, {}), StatusIs(absl::StatusCode::kInvalidArgument,
                                                        "pairs is empty, allowed: at least one"));
}

TEST_F(HostileStatesTest, UnknownPoolsAreNotFound) {
  const auto not_found = StatusIs(absl::StatusCode::kNotFound, "there is no pool pools/none");
  EXPECT_THAT(client_->SaveStates("pools/none"), not_found);
  EXPECT_THAT(client_->RestoreStates("pools/none", {StateOf(0, good_)}), not_found);
  EXPECT_THAT(client_->CloneStates("pools/none", {Pair(0, 1)}), not_found);
  EXPECT_THAT(client_->CloneStates(name_, {Pair(0, 1)}, {"pools/none", ""}), not_found);
  EXPECT_THAT(client_->SaveStates("none"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("pool name is 'none'")));
}

TEST_F(HostileStatesTest, ResponseSizesOutOfRangeAreRejected) {
  const auto stub = v1::StateService::NewStub(channel_);
  for (const auto& [bytes, code] :
       {std::pair<int64_t, grpc::StatusCode>{-1, grpc::StatusCode::INVALID_ARGUMENT},
        {65535, grpc::StatusCode::INVALID_ARGUMENT},
        {int64_t{16 << 20} + 1, grpc::StatusCode::RESOURCE_EXHAUSTED}}) {
    v1::SaveStatesRequest request;
    request.set_pool(name_);
    request.set_response_bytes_max(bytes);
    v1::SaveStatesResponse response;
    grpc::ClientContext context;
    const grpc::Status status = stub->SaveStates(&context, request, &response);
    EXPECT_EQ(status.error_code(), code);
    EXPECT_THAT(status.error_message(),
                HasSubstr("response_bytes_max is " + std::to_string(bytes)));
  }
}

// With a correct checksum a changed body may be a valid state, so a separate pool then has to step
// it.
TEST_F(HostileStatesTest, MutatedSnapshotsAreRejectedOrPlayable) {
  const std::string target = CreatePool(MazeSpec(1));
  const auto stream = client_->Attach(target);
  ASSERT_THAT(stream, IsOk());
  const std::string body = good_.substr(kSnapshotHeaderBytes);
  RandomStream random(4);
  int rejected = 0;
  for (int i = 0; i < 500; ++i) {
    std::string changed = body;
    changed[static_cast<size_t>(random.Int(static_cast<int32_t>(body.size())))] =
        static_cast<char>(random.Int(256));
    const absl::Status status =
        client_->RestoreStates(target, {StateOf(0, FrameSnapshot(changed))});
    EXPECT_THAT(status.code(),
                AnyOf(absl::StatusCode::kOk, absl::StatusCode::kInvalidArgument,
                      absl::StatusCode::kFailedPrecondition, absl::StatusCode::kDataLoss))
        << status;
    rejected += status.ok() ? 0 : 1;
    procgen_client::Batch batch;
    ASSERT_THAT((*stream)->Step({random.Int(15)}, &batch), IsOk());
  }
  EXPECT_GT(rejected, 0);
}

}  // namespace
}  // namespace procgen
