// Invalid snapshots and invalid state requests: each ends the stream with a reason. The server and
// other pools continue.

#include <string>
#include <vector>

#include "envcore/random/random_stream.h"
#include "envcore/state/snapshot_frame.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

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

class HostileStatesTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    const auto run = NewPool();
    v1::Batch batch;
    ASSERT_THAT(run->Step({7, 7}, &batch), IsOk());
    good_ = run->Save({0})->front().snapshot();
    EXPECT_THAT(run->Close(), IsOk());
  }

  // A pool of two mazes.
  std::unique_ptr<PoolStream> NewPool() { return StartPool(MazeSpec(2), "mine"); }

  // Restores environment 0 of a new pool from a valid snapshot, and environment 1 from `snapshot`.
  absl::Status Restore(const std::string& snapshot) {
    return NewPool()->Restore({StateOf(0, good_), StateOf(1, snapshot)});
  }

  std::string good_;
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
  for (int i = 0; i < 100; ++i) {
    const std::string cut =
        good_.substr(0, static_cast<size_t>(random.Int(static_cast<int32_t>(good_.size()))));
    EXPECT_THAT(Restore(cut), StatusIs(absl::StatusCode::kDataLoss, HasSubstr("environment 1")));
    std::string flipped = good_;
    flipped[static_cast<size_t>(random.Int(static_cast<int32_t>(good_.size())))] ^= 0x10;
    EXPECT_THAT(Restore(flipped), StatusIs(absl::StatusCode::kDataLoss, testing::_));
  }
}

TEST_F(HostileStatesTest, PoolWithADamagedSnapshotIsNotCreated) {
  EXPECT_THAT(PoolStream(channel_).Start(MazeSpec(2), {StateOf(1, "nonsense")}, "mine"),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("environment 1: the snapshot")));
  EXPECT_THAT(client_->GetPool("pools/mine"), StatusIs(absl::StatusCode::kNotFound, testing::_));
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
  v1::PoolSpec spec = MazeSpec(2);
  *spec.mutable_games(0) = "miner";
  const auto other_game = StatusIs(absl::StatusCode::kFailedPrecondition,
                                   "environment 1: game is miner, the environment plays maze");
  EXPECT_THAT(Restore(StartPool(spec)->Save()->front().snapshot()), other_game);
  spec.add_games("maze");
  EXPECT_THAT(StartPool(spec)->Clone({Pair(0, 1)}), other_game);
}

TEST_F(HostileStatesTest, SnapshotLargerThanARequestIsRejected) {
  EXPECT_THAT(Restore(std::string(70000, 'x')),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("65536")));
}

TEST_F(HostileStatesTest, SnapshotLargerThanTheMaximumIsDataLoss) {
  const auto large = StartServer(/*worker_count=*/1, Limits());
  ASSERT_NE(large, nullptr);
  EXPECT_THAT(PoolStream(ChannelTo(large->address()))
                  .Start(MazeSpec(1), {StateOf(0, FrameSnapshot(std::string(2 << 20, 'x')))}),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("must have at most 1048576")));
}

TEST_F(HostileStatesTest, EnvironmentsOutOfRangeOrRepeatedAreRejected) {
  const auto out_of_range = [](const std::string& what) {
    return StatusIs(absl::StatusCode::kInvalidArgument,
                    what + ", pool pools/mine has environments 0 to 1");
  };
  const auto twice = [](const std::string& what) {
    return StatusIs(absl::StatusCode::kInvalidArgument,
                    what + " again, allowed: each at most once");
  };
  EXPECT_THAT(NewPool()->Save({0, 2}), out_of_range("environments[1] is 2"));
  EXPECT_THAT(NewPool()->Save({1, 0, 1}), twice("environments[2] is 1"));
  EXPECT_THAT(NewPool()->Restore({StateOf(-1, good_)}),
              out_of_range("states[0].environment is -1"));
  EXPECT_THAT(NewPool()->Restore({StateOf(1, good_), StateOf(1, good_)}),
              twice("states[1].environment is 1"));
  EXPECT_THAT(NewPool()->Clone({Pair(0, 1), Pair(5, 0)}),
              out_of_range("pairs[1].source_environment is 5"));
  EXPECT_THAT(NewPool()->Clone({Pair(0, 7)}), out_of_range("pairs[0].target_environment is 7"));
  EXPECT_THAT(NewPool()->Clone({Pair(0, 1), Pair(1, 1)}),
              twice("pairs[1].target_environment is 1"));
}

TEST_F(HostileStatesTest, EmptyRestoreOrCloneIsRejected) {
  EXPECT_THAT(NewPool()->Restore({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                               "states is empty, allowed: at least one"));
  EXPECT_THAT(NewPool()->Clone({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                             "pairs is empty, allowed: at least one"));
}

// With a correct checksum a changed body may be a valid state, so the pool then has to step it.
TEST_F(HostileStatesTest, MutatedSnapshotsAreRejectedOrPlayable) {
  const std::string body = good_.substr(kSnapshotHeaderBytes);
  RandomStream random(4);
  int rejected = 0;
  for (int i = 0; i < 500; ++i) {
    std::string changed = body;
    changed[static_cast<size_t>(random.Int(static_cast<int32_t>(body.size())))] =
        static_cast<char>(random.Int(256));
    PoolStream run(channel_);
    const absl::Status status =
        run.Start(MazeSpec(1), {StateOf(0, FrameSnapshot(changed))}).status();
    EXPECT_THAT(status.code(),
                AnyOf(absl::StatusCode::kOk, absl::StatusCode::kInvalidArgument,
                      absl::StatusCode::kFailedPrecondition, absl::StatusCode::kDataLoss))
        << status;
    if (status.ok()) {
      v1::Batch batch;
      ASSERT_THAT(run.Step({random.Int(15)}, &batch), IsOk());
      ASSERT_THAT(run.Close(), IsOk());
    }
    rejected += status.ok() ? 0 : 1;
  }
  EXPECT_GT(rejected, 0);
}

}  // namespace
}  // namespace procgen
