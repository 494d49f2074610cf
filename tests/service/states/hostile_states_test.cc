// Invalid snapshots and invalid state requests: each ends the stream with a reason. The server and
// other pools continue.

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

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

TEST_F(HostileStatesTest, PoolWithADamagedSnapshotIsNotCreated) {
  EXPECT_THAT(PoolStream(channel_).Start(MazeSpec(2), {StateOf(1, "nonsense")}, "mine"),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("environment 1: the snapshot")));
  EXPECT_THAT(client_->GetPool("pools/mine"), StatusIs(absl::StatusCode::kNotFound, testing::_));
}

TEST_F(HostileStatesTest, SnapshotLargerThanARequestIsRejected) {
  EXPECT_THAT(Restore(std::string(70000, 'x')),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("65536")));
}

}  // namespace
}  // namespace procgen
