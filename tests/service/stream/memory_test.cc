// The server's memory for what learners send is bounded.

#include <memory>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/concurrency/steady_time.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

// A second server, with a small limit of bytes per owner.
class MemoryTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    Limits limits = TestLimits();
    limits.request_bytes_max = 4 << 20;
    limits.owner_bytes_max = 20 << 20;
    small_ = StartServer(/*worker_count=*/2, limits);
    ASSERT_NE(small_, nullptr);
    channel_ = ChannelTo(small_->address());
  }

  // A level sampler that takes `count` * 16 bytes in a pool.
  static v1::LevelSampler SamplerOfSize(int32_t count) {
    v1::LevelSampler sampler;
    for (int32_t i = 0; i < count; ++i) {
      sampler.add_level_seeds(i);
      sampler.add_weights(1);
    }
    return sampler;
  }

 private:
  std::unique_ptr<Server> small_;
};

TEST_F(MemoryTest, LevelSamplersCountUntilTheirPoolsEnd) {
  v1::PoolSpec spec = MazeSpec(1);
  *spec.mutable_level_sampler() = SamplerOfSize(500'000);  // 8 MB
  const auto first = StartPool(spec);
  const auto second = StartPool(spec);
  EXPECT_THAT(StartError(spec), StatusIs(absl::StatusCode::kResourceExhausted,
                                         HasSubstr("limit owner_bytes_max is 20971520")));
  EXPECT_THAT(StartError(MazeSpec(1)), IsOk()) << "a pool without a sampler takes 0.1 MB";
  ASSERT_THAT(first->Close(), IsOk());
  // The pool is freed in the background.
  while (!StartError(spec).ok()) {
  }
}

TEST_F(MemoryTest, ReplacedSamplerIsNotCounted) {
  const auto stream = StartPool(MazeSpec(2));
  v1::RunPoolRequest request;
  *request.mutable_level_sampler() = SamplerOfSize(200'000);  // 3 MB
  v1::Batch batch;
  for (int i = 0; i < 20; ++i) {
    ASSERT_THAT(stream->Call(request), IsOk()) << i;
    ASSERT_THAT(stream->Step({4, 4}, &batch), IsOk());
  }
}

TEST_F(MemoryTest, IdleStreamsKeepNoLargeRequests) {
  // Unknown fields of 2 bytes each on the wire, and 16 or more in memory.
  std::string unknown;
  for (int i = 0; i < 80'000; ++i) {
    unknown += "\x78\x01";
  }
  v1::RunPoolRequest request = ObserveRequest(1);
  ASSERT_TRUE(request.MergeFromString(unknown));
  const auto stream = StartPool(MazeSpec(1));
  v1::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  const int64_t before = AllocatedBytes();
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 16; ++i) {
      ASSERT_TRUE(stream->Write(request));
    }
    for (int i = 0; i < 16; ++i) {
      ASSERT_THAT(stream->Read(&batch), IsOk());
    }
  }
  // gRPC frees buffers a little later.
  const absl::Time deadline = SteadyNow() + absl::Seconds(30);
  while (AllocatedBytes() - before >= 4 << 20 && SteadyNow() < deadline) {
    absl::SleepFor(absl::Milliseconds(20));
  }
  EXPECT_LT(AllocatedBytes() - before, 4 << 20);
}

}  // namespace
}  // namespace procgen
