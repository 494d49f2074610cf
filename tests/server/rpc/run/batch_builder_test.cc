#include "server/rpc/run/batch_builder.h"

#include <algorithm>
#include <memory>
#include <random>

#include "gtest/gtest.h"
#include "server/wire/convert_step.h"
#include "tests/server/pool/test_pool_context.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

// The most environments that a response of `bytes_max` has room for.
int32_t CountMax(Request request, Encoding encoding, int64_t observation_bytes, int64_t bytes_max) {
  request.count = 1;
  while (CheckResponseFits(request, encoding, observation_bytes, bytes_max).ok()) {
    ++request.count;
  }
  return request.count - 1;
}

// With incompressible observations, and every episode ended.
TEST(BatchBuilderTest, ResponsesWithinTheirLimitFitAndOneMoreEnvironmentWouldNot) {
  constexpr int64_t kLimit = 1 << 20;
  for (const Encoding encoding : {Encoding::kRaw, Encoding::kDeltaZstd}) {
    TestPoolContext context;
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = 100;
    auto pool = Pool::Create(options, std::make_shared<WorkerPool>(1));
    ASSERT_THAT(pool, IsOk());
    SessionOptions session_options;
    session_options.encoding = encoding;
    const PoolSession session(
        "", "pools/7", *std::move(pool), session_options, [](const absl::Status&) {},
        context.Get());
    BatchBuilder builder(session);
    std::mt19937 random;
    for (const bool with_final : {false, true}) {
      Request request;
      request.with_final_observations = with_final;
      request.count = CountMax(request, encoding, session.observation_bytes(), kLimit);
      EXPECT_GT(request.count, with_final ? 40 : 80);
      const auto size = [&] {
        const Batch batch = builder.Prepare(request);
        std::fill(batch.rewards.begin(), batch.rewards.end(), 1);
        std::fill(batch.terminated.begin(), batch.terminated.end(), 1);
        std::generate(batch.observations.begin(), batch.observations.end(),
                      [&] { return static_cast<uint8_t>(random()); });
        return static_cast<int64_t>(builder.Finish().Length());
      };
      EXPECT_LE(size(), kLimit);
      ++request.count;
      // The bound of encoded observations leaves some room.
      EXPECT_GT(size() + (encoding == Encoding::kRaw ? 512 : 2 * kObservationBytes), kLimit);
    }
  }
}

}  // namespace
}  // namespace procgen
